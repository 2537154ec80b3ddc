#include "common/support/huge_pages.h"

#include <sys/mman.h>

#include <memory>

namespace lumenfarm {

void prefer_huge_pages(void* begin, std::size_t bytes) {
    constexpr std::size_t huge_page_bytes = 2u << 20;
    void* aligned = begin;
    // whole pages inside the range; a refusal leaves the memory as it was
    if (std::align(huge_page_bytes, huge_page_bytes, aligned, bytes)) ::madvise(aligned, bytes, MADV_HUGEPAGE);
}

}  // namespace lumenfarm
