# Writes include/raybundle/version.h. The commit is looked up at every build, not at configure time,
# so that a log never names a commit it was not made by; the header changes only when the text does.
set(version_arguments
    "-Dsource=${PROJECT_SOURCE_DIR}"
    "-Dtemplate=${PROJECT_SOURCE_DIR}/tools/cmake/version.h.in"
    "-Doutput=${PROJECT_BINARY_DIR}/include/raybundle/version.h"
    "-Dversion=${PROJECT_VERSION}"
    "-Dmajor=${PROJECT_VERSION_MAJOR}"
    "-Dminor=${PROJECT_VERSION_MINOR}"
    "-Dpatch=${PROJECT_VERSION_PATCH}"
    "-Dcompiler=${CMAKE_CXX_COMPILER_ID} ${CMAKE_CXX_COMPILER_VERSION}"
    "-Dsystem=${CMAKE_SYSTEM_NAME} ${CMAKE_SYSTEM_PROCESSOR}"
    "-Dbuild_type=${CMAKE_BUILD_TYPE}")
add_custom_target(
  raybundle_version
  COMMAND "${CMAKE_COMMAND}" ${version_arguments} -P
          "${PROJECT_SOURCE_DIR}/tools/cmake/write_version.cmake"
  BYPRODUCTS "${PROJECT_BINARY_DIR}/include/raybundle/version.h"
  COMMENT "Recording version and commit"
  VERBATIM)
# Also at configure time, for tools that read the header before anything is built (clang-tidy).
execute_process(COMMAND "${CMAKE_COMMAND}" ${version_arguments} -P
                        "${PROJECT_SOURCE_DIR}/tools/cmake/write_version.cmake"
                COMMAND_ERROR_IS_FATAL ANY)
unset(version_arguments)
