#pragma once
/// How often a thread asks for memory. Programs that link counted_memory.cpp have its operator new.
namespace equistream::test {

/// Of the thread that makes it, while it lives; one at a time.
class CountedMemory {
public:
    CountedMemory();
    ~CountedMemory();
    CountedMemory(const CountedMemory&) = delete;
    CountedMemory& operator=(const CountedMemory&) = delete;

    int allocations() const;
};

}  // namespace equistream::test
