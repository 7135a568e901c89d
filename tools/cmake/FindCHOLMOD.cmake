# Finds CHOLMOD of SuiteSparse and defines the target CHOLMOD::CHOLMOD, and CHOLMOD_VERSION.
#
# SuiteSparse 7 and later bring a package config, which is used where it is found. Earlier ones (5.12
# in Debian 12) bring none: header and library are looked up here. BLAS and LAPACK, and AMD, COLAMD,
# CAMD, CCOLAMD, come along as dependencies of the shared library.
include(FindPackageHandleStandardArgs)

if(NOT CHOLMOD_LIBRARY)
  find_package(CHOLMOD CONFIG QUIET)
endif()
if(TARGET SuiteSparse::CHOLMOD)
  find_package_handle_standard_args(CHOLMOD CONFIG_MODE)
  if(NOT TARGET CHOLMOD::CHOLMOD)
    add_library(CHOLMOD::CHOLMOD INTERFACE IMPORTED)
    set_target_properties(CHOLMOD::CHOLMOD PROPERTIES INTERFACE_LINK_LIBRARIES SuiteSparse::CHOLMOD)
  endif()
  return()
endif()

find_path(CHOLMOD_INCLUDE_DIR NAMES cholmod.h PATH_SUFFIXES suitesparse)
find_library(CHOLMOD_LIBRARY NAMES cholmod)

if(CHOLMOD_INCLUDE_DIR AND EXISTS "${CHOLMOD_INCLUDE_DIR}/cholmod_core.h")
  file(STRINGS "${CHOLMOD_INCLUDE_DIR}/cholmod_core.h" lines
       REGEX "^#define CHOLMOD_(MAIN|SUB|SUBSUB)_VERSION +[0-9]+")
  string(REGEX REPLACE "[^0-9;]" "" CHOLMOD_VERSION "${lines}")
  string(REPLACE ";" "." CHOLMOD_VERSION "${CHOLMOD_VERSION}")
  unset(lines)
endif()

find_package_handle_standard_args(
  CHOLMOD
  REQUIRED_VARS CHOLMOD_LIBRARY CHOLMOD_INCLUDE_DIR
  VERSION_VAR CHOLMOD_VERSION
  REASON_FAILURE_MESSAGE "install SuiteSparse (Debian, Ubuntu: libsuitesparse-dev)")

if(CHOLMOD_FOUND AND NOT TARGET CHOLMOD::CHOLMOD)
  add_library(CHOLMOD::CHOLMOD UNKNOWN IMPORTED)
  set_target_properties(CHOLMOD::CHOLMOD PROPERTIES IMPORTED_LOCATION "${CHOLMOD_LIBRARY}"
                                                    INTERFACE_INCLUDE_DIRECTORIES "${CHOLMOD_INCLUDE_DIR}")
endif()
mark_as_advanced(CHOLMOD_INCLUDE_DIR CHOLMOD_LIBRARY)
