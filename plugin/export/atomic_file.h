#pragma once
/// A file that is written beside its name and appears under it only when it is whole.
#include <cstddef>
#include <cstdint>
#include <filesystem>

namespace equistream {

/// Not thread-safe. Every failure throws WorkError naming the file; an uncommitted file is removed.
/// The aside name is fixed (".NAME.aside") and locked while it is written: what a killed run left is taken over by
/// the next one, and two processes never write the same file at once.
class AtomicFile {
public:
    explicit AtomicFile(std::filesystem::path file);
    ~AtomicFile();
    AtomicFile(const AtomicFile&) = delete;
    AtomicFile& operator=(const AtomicFile&) = delete;

    void write_at(const void* data, std::size_t bytes, std::uint64_t offset);
    /// Syncs, renames to the final name, syncs the folder.
    void commit();

private:
    [[noreturn]] void fail(const char* what, int error_number) const;

    std::filesystem::path file_;
    std::filesystem::path aside_;
    int descriptor_ = -1;
};

}  // namespace equistream
