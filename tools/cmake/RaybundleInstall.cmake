# Install rules and package config: find_package(raybundle) gives raybundle::raybundle.
include(CMakePackageConfigHelpers)
set(package_dir "${CMAKE_INSTALL_LIBDIR}/cmake/raybundle")

install(TARGETS raybundle EXPORT raybundleTargets ARCHIVE DESTINATION "${CMAKE_INSTALL_LIBDIR}")
if(TARGET raybundle-cli)
  install(TARGETS raybundle-cli RUNTIME DESTINATION "${CMAKE_INSTALL_BINDIR}")
endif()

foreach(folder IN ITEMS linalg models solver)
  install(
    DIRECTORY "${PROJECT_SOURCE_DIR}/${folder}/"
    DESTINATION "${CMAKE_INSTALL_INCLUDEDIR}/raybundle/${folder}"
    FILES_MATCHING
    PATTERN "*.h"
    PATTERN "*_impl.h" EXCLUDE # bodies that are compiled once per instruction set
    PATTERN "cholmod_*.h" EXCLUDE) # speak CHOLMOD's types
endforeach()
install(FILES "${PROJECT_BINARY_DIR}/include/raybundle/version.h"
        DESTINATION "${CMAKE_INSTALL_INCLUDEDIR}/raybundle")
install(FILES "${PROJECT_SOURCE_DIR}/LICENSE" DESTINATION "${CMAKE_INSTALL_DOCDIR}")

install(EXPORT raybundleTargets NAMESPACE raybundle:: DESTINATION "${package_dir}")
configure_package_config_file(
  "${PROJECT_SOURCE_DIR}/tools/cmake/raybundleConfig.cmake.in"
  "${PROJECT_BINARY_DIR}/raybundleConfig.cmake" INSTALL_DESTINATION "${package_dir}")
# Before 1.0 a minor version may change the interface.
write_basic_package_version_file("${PROJECT_BINARY_DIR}/raybundleConfigVersion.cmake"
                                 COMPATIBILITY SameMinorVersion)
install(
  FILES "${PROJECT_BINARY_DIR}/raybundleConfig.cmake"
        "${PROJECT_BINARY_DIR}/raybundleConfigVersion.cmake"
        "${PROJECT_SOURCE_DIR}/tools/cmake/FindCHOLMOD.cmake"
  DESTINATION "${package_dir}")
