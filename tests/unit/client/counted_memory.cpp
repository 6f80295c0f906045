#include "counted_memory.h"

#include <cstddef>
#include <cstdlib>
#include <new>

namespace {

thread_local bool is_counting = false;
thread_local int count = 0;
thread_local std::size_t bytes_asked_for = 0;

}  // namespace

void* operator new(std::size_t size, const std::nothrow_t&) noexcept {
    count += is_counting ? 1 : 0;
    bytes_asked_for += is_counting ? size : 0;
    return std::malloc(size);
}
void* operator new(std::size_t size) {
    if (void* memory = operator new(size, std::nothrow))
        return memory;
    throw std::bad_alloc();
}
void operator delete(void* memory) noexcept {
    std::free(memory);
}
void operator delete(void* memory, std::size_t) noexcept {
    std::free(memory);
}

namespace equistream::test {

CountedMemory::CountedMemory() {
    count = 0;
    bytes_asked_for = 0;
    is_counting = true;
}

CountedMemory::~CountedMemory() {
    is_counting = false;
}

int CountedMemory::allocations() const {
    return count;
}

std::size_t CountedMemory::bytes() const {
    return bytes_asked_for;
}

}  // namespace equistream::test
