# One place for the compiler's flags. -ffp-contract=off is law 9: a fused multiply-add would change bits from machine to
# machine. x86-64-v2 is the oldest PC that is served.
add_library(lumenfarm_flags INTERFACE)
target_compile_options(lumenfarm_flags INTERFACE
  -march=x86-64-v2 -ffp-contract=off
  -Wall -Wextra -Wpedantic -Wshadow -Wconversion -Wno-sign-conversion -Wnon-virtual-dtor -Woverloaded-virtual -Werror)
target_include_directories(lumenfarm_flags INTERFACE ${CMAKE_SOURCE_DIR})
string(APPEND CMAKE_CXX_FLAGS_RELEASE " -O2")
string(REPLACE "-O3" "" CMAKE_CXX_FLAGS_RELEASE "${CMAKE_CXX_FLAGS_RELEASE}")
string(REPLACE "-DNDEBUG" "" CMAKE_CXX_FLAGS_RELEASE "${CMAKE_CXX_FLAGS_RELEASE}")

if(LUMENFARM_SANITIZE)
  add_compile_options(-fsanitize=${LUMENFARM_SANITIZE} -fno-omit-frame-pointer -fno-sanitize-recover=all)
  add_link_options(-fsanitize=${LUMENFARM_SANITIZE})
  # g++ 12 sees uninitialised members of variants where its own instrumentation hides their construction
  add_compile_options($<$<CXX_COMPILER_ID:GNU>:-Wno-maybe-uninitialized>)
  # Asio's fences stand beside its mutexes, which ThreadSanitizer does see
  if(LUMENFARM_SANITIZE STREQUAL "thread")
    add_compile_options($<$<CXX_COMPILER_ID:GNU>:-Wno-tsan>)
  endif()
endif()
if(LUMENFARM_FUZZ)
  add_compile_options(-fsanitize=fuzzer-no-link,address,undefined -fno-omit-frame-pointer -fno-sanitize-recover=all)
  add_link_options(-fsanitize=address,undefined)
endif()
