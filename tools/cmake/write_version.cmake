# Script: fills version.h.in. Arguments as passed by RaybundleVersion.cmake.
cmake_policy(VERSION 3.25)
set(commit "no commit recorded")
find_program(git NAMES git)
if(git AND EXISTS "${source}/.git") # a tarball inside somebody else's repository has none
  execute_process(
    COMMAND "${git}" -C "${source}" describe --always --dirty --tags
    OUTPUT_VARIABLE described
    OUTPUT_STRIP_TRAILING_WHITESPACE
    ERROR_QUIET
    RESULT_VARIABLE status)
  if(status EQUAL 0 AND described)
    set(commit "commit ${described}")
  endif()
endif()
if(NOT build_type)
  set(build_type "no build type")
endif()
configure_file("${template}" "${output}" @ONLY)
