# A room is a folder with one purpose: its sources make one library, its tests (tests/<same path>) one program.

# lumenfarm_room(NAME LINK ...): the library lumenfarm_NAME of this folder's *.cpp, main.cpp left out.
function(lumenfarm_room name)
  cmake_parse_arguments(arg "" "" "LINK" ${ARGN})
  file(GLOB sources CONFIGURE_DEPENDS ${CMAKE_CURRENT_SOURCE_DIR}/*.cpp)
  list(FILTER sources EXCLUDE REGEX "/main\\.cpp$")
  if(NOT sources)
    add_library(lumenfarm_${name} INTERFACE)
    target_link_libraries(lumenfarm_${name} INTERFACE lumenfarm_flags ${arg_LINK})
    return()
  endif()
  add_library(lumenfarm_${name} STATIC ${sources})
  target_link_libraries(lumenfarm_${name} PUBLIC lumenfarm_flags ${arg_LINK})
endfunction()

# lumenfarm_program(NAME LINK ...): the program NAME of this folder's main.cpp.
function(lumenfarm_program name)
  cmake_parse_arguments(arg "" "" "LINK" ${ARGN})
  if(EXISTS ${CMAKE_CURRENT_SOURCE_DIR}/main.cpp)
    add_executable(${name} main.cpp)
    target_link_libraries(${name} PRIVATE ${arg_LINK})
    set_target_properties(${name} PROPERTIES RUNTIME_OUTPUT_DIRECTORY ${CMAKE_BINARY_DIR}/bin)
  endif()
endfunction()

# lumenfarm_tests(FOLDER LINK ... [TIMEOUT seconds]): the program FOLDER_tests of tests/FOLDER/*.cpp, one ctest each case.
function(lumenfarm_tests folder)
  cmake_parse_arguments(arg "" "TIMEOUT" "LINK" ${ARGN})
  file(GLOB sources CONFIGURE_DEPENDS ${CMAKE_CURRENT_SOURCE_DIR}/${folder}/*.cpp)
  if(NOT sources)
    return()
  endif()
  if(NOT arg_TIMEOUT)
    set(arg_TIMEOUT 300)
  endif()
  string(REPLACE "/" "_" program ${folder})
  add_executable(${program}_tests ${sources})
  target_link_libraries(${program}_tests PRIVATE lumenfarm_flags ${arg_LINK} GTest::gmock_main)
  target_compile_definitions(${program}_tests PRIVATE
    LUMENFARM_SOURCE_DIR="${CMAKE_SOURCE_DIR}" LUMENFARM_BINARY_DIR="${CMAKE_BINARY_DIR}")
  gtest_discover_tests(${program}_tests DISCOVERY_TIMEOUT 60 TEST_PREFIX "${program}/" PROPERTIES TIMEOUT ${arg_TIMEOUT})
endfunction()
