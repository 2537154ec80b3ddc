#pragma once

#include <cstddef>

namespace lumenfarm {

/// Asks the system to back the memory of [begin, begin + bytes) with huge pages, where it has them: a table that is
/// read at random then costs far fewer address look-ups. Advice only, before the memory is first touched.
void prefer_huge_pages(void* begin, std::size_t bytes);

}  // namespace lumenfarm
