#pragma once

namespace lumenfarm {

/// Stops the program when an assumption of the code is broken; stays in release builds. Never for foreign input.
void ensure(bool holds, const char* assumption, const char* file = __builtin_FILE(), int line = __builtin_LINE());

}  // namespace lumenfarm
