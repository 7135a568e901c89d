# Helpers by which the folders declare their targets, so that each CMakeLists.txt stays a few lines.

# Links `<root>/raybundle/<folder>` to the source folder, for each folder named.
function(raybundle_link_farm root)
  file(MAKE_DIRECTORY "${root}/raybundle")
  foreach(folder IN LISTS ARGN)
    if(EXISTS "${PROJECT_SOURCE_DIR}/${folder}")
      file(CREATE_LINK "${PROJECT_SOURCE_DIR}/${folder}" "${root}/raybundle/${folder}" SYMBOLIC)
    endif()
  endforeach()
endfunction()

# What every file of ours is compiled with.
function(raybundle_warnings target)
  target_compile_options(
    ${target}
    PRIVATE -Wall -Wextra -Wpedantic -Wshadow -Wconversion -Wnon-virtual-dtor -Woverloaded-virtual
            $<$<BOOL:${RAYBUNDLE_WERROR}>:-Werror>)
  if(CMAKE_CXX_COMPILER_ID MATCHES "Clang")
    target_compile_options(${target} PRIVATE -Wno-sign-conversion) # as GCC understands -Wconversion
  elseif(RAYBUNDLE_WERROR AND CMAKE_CXX_COMPILER_ID STREQUAL "GNU")
    # GCC's flow analyses see Eigen and std::string after inlining and warn of what cannot happen
    # there (GCC 12: -Wrestrict on every `"text" + std::string`, its bug 105651).
    target_compile_options(
      ${target} PRIVATE -Wno-restrict -Wno-error=array-bounds -Wno-error=maybe-uninitialized
                        -Wno-error=stringop-overflow)
  endif()
endfunction()

# Include paths, language level and dependencies of the library, of its layers as of the whole.
function(raybundle_library_usage target)
  target_compile_features(${target} PUBLIC cxx_std_20)
  set_target_properties(${target} PROPERTIES CXX_EXTENSIONS OFF POSITION_INDEPENDENT_CODE ON)
  target_include_directories(${target} PUBLIC $<BUILD_INTERFACE:${PROJECT_BINARY_DIR}/include>
                                              $<INSTALL_INTERFACE:${CMAKE_INSTALL_INCLUDEDIR}>)
  target_link_libraries(
    ${target}
    PUBLIC Eigen3::Eigen
    PRIVATE CHOLMOD::CHOLMOD Threads::Threads ${CMAKE_DL_LIBS})
  add_dependencies(${target} raybundle_version)
endfunction()

# Gives files named *_avx2.cc and *_avx512.cc their instruction set, of exactly the extensions that
# linalg/cpu.cc looks for; the program chooses among them when it runs. On other processors they are left out. Such files must not instantiate inline
# functions of headers: the linker keeps one copy of those, and could keep the one with the wrong
# instructions (tests: isa_isolation).
function(raybundle_instruction_sets sources_variable)
  set(sources ${${sources_variable}})
  foreach(source IN LISTS sources)
    if(source MATCHES "_avx2\\.cc$" AND RAYBUNDLE_X86_KERNELS)
      set_source_files_properties("${source}" PROPERTIES COMPILE_OPTIONS "-mavx2;-mfma")
    elseif(source MATCHES "_avx512\\.cc$" AND RAYBUNDLE_X86_KERNELS)
      set_source_files_properties(
        "${source}"
        PROPERTIES
          COMPILE_OPTIONS
          "-mfma;-mavx512f;-mavx512cd;-mavx512bw;-mavx512dq;-mavx512vl;-mtune=skylake-avx512;-mprefer-vector-width=512"
      )
    elseif(source MATCHES "_avx(2|512)\\.cc$")
      list(REMOVE_ITEM ${sources_variable} "${source}")
    endif()
  endforeach()
  set(${sources_variable} ${${sources_variable}} PARENT_SCOPE)
endfunction()

# Object library `raybundle_<layer>` of all *.cc beneath the calling folder.
function(raybundle_add_layer layer)
  # Globbing costs a directory scan per build and spares a list that everybody edits.
  file(GLOB_RECURSE sources CONFIGURE_DEPENDS "${CMAKE_CURRENT_SOURCE_DIR}/*.cc")
  raybundle_instruction_sets(sources)
  if(NOT sources)
    message(STATUS "raybundle: no sources in ${layer}")
    return()
  endif()
  set(target raybundle_${layer})
  add_library(${target} OBJECT ${sources})
  raybundle_library_usage(${target})
  raybundle_warnings(${target})
  # Neither -fno flag changes a result: nobody here reads errno or the floating-point exception flags.
  # -Wpsabi speaks of vectors passed between files; the kernels pass them within one only.
  target_compile_options(${target} PRIVATE -fno-math-errno -fno-trapping-math -Wno-psabi)
  if(RAYBUNDLE_X86_KERNELS)
    target_compile_definitions(${target} PRIVATE RAYBUNDLE_HAVE_X86_KERNELS=1)
  endif()
endfunction()

include(CheckCXXCompilerFlag)
if(CMAKE_SYSTEM_PROCESSOR MATCHES "^(x86_64|AMD64|amd64)$")
  check_cxx_compiler_flag("-mavx2 -mfma" RAYBUNDLE_COMPILER_HAS_AVX2)
  check_cxx_compiler_flag("-mavx512f -mavx512vl -mprefer-vector-width=512"
                          RAYBUNDLE_COMPILER_HAS_AVX512)
endif()
if(RAYBUNDLE_COMPILER_HAS_AVX2 AND RAYBUNDLE_COMPILER_HAS_AVX512)
  set(RAYBUNDLE_X86_KERNELS ON)
else()
  set(RAYBUNDLE_X86_KERNELS OFF)
endif()
