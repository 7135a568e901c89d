# Script: builds tests/package as a stranger would and runs the example program.
#   -Dmode=find_package|add_subdirectory  -Dsource=<root>  -Dbuild=<build folder>  -Dwork=<scratch>
#   -Dgenerator=... -Dcompiler=... -Ddata=<BAL file, may be absent>
cmake_policy(VERSION 3.25)

function(run)
  execute_process(COMMAND ${ARGN} COMMAND_ECHO STDOUT COMMAND_ERROR_IS_FATAL ANY)
endfunction()

file(REMOVE_RECURSE "${work}")
set(arguments -G "${generator}" "-DCMAKE_CXX_COMPILER=${compiler}" -DCMAKE_BUILD_TYPE=Release
              "-DEXAMPLES=${source}/docs/examples")
if(mode STREQUAL "find_package")
  run("${CMAKE_COMMAND}" --install "${build}" --prefix "${work}/prefix")
  list(APPEND arguments "-DCMAKE_PREFIX_PATH=${work}/prefix" "-DHEADERS=${work}/prefix/include")
else()
  list(APPEND arguments "-DRAYBUNDLE_SOURCE=${source}")
endif()

run("${CMAKE_COMMAND}" -S "${source}/tests/package" -B "${work}/build" ${arguments})
run("${CMAKE_COMMAND}" --build "${work}/build")
run("${work}/build/embed")
if(EXISTS "${data}")
  run("${work}/build/embed" "${data}")
endif()
if(mode STREQUAL "find_package")
  run("${work}/prefix/bin/raybundle" version)
endif()

# Bad input ends with a message, not with a crash.
execute_process(COMMAND "${work}/build/embed" "${work}/absent.txt" RESULT_VARIABLE status
                ERROR_VARIABLE message)
if(NOT status EQUAL 2 OR NOT message MATCHES "absent\\.txt")
  message(FATAL_ERROR "a file that is not there: status ${status}, message: ${message}")
endif()
