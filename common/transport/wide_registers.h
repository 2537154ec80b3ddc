#pragma once

namespace lumenfarm {

/// True where the functions marked with target "avx2,bmi,bmi2" can run. They do the same IEEE arithmetic as the
/// baseline: fused multiply-add is left out of that list, so that no bit depends on this (law 9).
inline bool has_wide_registers() { return __builtin_cpu_supports("avx2") && __builtin_cpu_supports("bmi2"); }

}  // namespace lumenfarm
