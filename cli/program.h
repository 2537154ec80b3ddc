#pragma once

/// The program `lumenfarm`.
namespace lumenfarm {

/// Parses, runs and reports. Gives the exit status: 0 done, 1 failed, 2 bad input or usage, 3 interrupted.
int run_program(int argc, const char* const* argv);

}  // namespace lumenfarm
