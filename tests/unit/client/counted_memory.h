#pragma once
/// How often a thread asks for memory, and for how much. Programs that link counted_memory.cpp have its operator new.
#include <cstddef>

namespace equistream::test {

/// Of the thread that makes it, while it lives; one at a time.
class CountedMemory {
public:
    CountedMemory();
    ~CountedMemory();
    CountedMemory(const CountedMemory&) = delete;
    CountedMemory& operator=(const CountedMemory&) = delete;

    int allocations() const;
    std::size_t bytes() const;  ///< of all of them
};

}  // namespace equistream::test
