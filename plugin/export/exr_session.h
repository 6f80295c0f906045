#pragma once
/// OpenEXRCore contexts over our own files: errors are kept, not printed, and every call's result is checked.
#include "atomic_file.h"

#include <openexr.h>

#include <cstdint>
#include <filesystem>
#include <mutex>
#include <string>

namespace equistream {

/// One context, for reading or for writing. The const parts may be used by several threads.
class ExrSession {
public:
    /// Opens for reading; throws InputError naming the file if it is missing or not an EXR.
    static ExrSession for_reading(const std::filesystem::path& file) { return ExrSession(file, nullptr); }
    /// Writes into `target`, which must outlive the session.
    static ExrSession for_writing(const std::filesystem::path& file, AtomicFile& target) {
        return ExrSession(file, &target);
    }
    ~ExrSession();
    ExrSession(const ExrSession&) = delete;
    ExrSession& operator=(const ExrSession&) = delete;

    exr_context_t context() const { return context_; }
    const std::filesystem::path& file() const { return file_; }
    std::int64_t size_bytes() const { return size_bytes_; }

    /// Throws (InputError when reading, WorkError when writing) unless `result` is success.
    void check(exr_result_t result, const char* doing) const;
    /// Forgets errors that were expected, such as an absent attribute's.
    void forget_errors() const;
    [[noreturn]] void refuse(const std::string& expected, const std::string& found) const;

private:
    ExrSession(const std::filesystem::path& file, AtomicFile* target);
    void open_descriptor();

    static std::int64_t read_callback(exr_const_context_t, void* self, void* buffer, std::uint64_t bytes,
                                      std::uint64_t offset, exr_stream_error_func_ptr_t error);
    static std::int64_t size_callback(exr_const_context_t, void* self);
    static std::int64_t write_callback(exr_const_context_t, void* self, const void* buffer, std::uint64_t bytes,
                                       std::uint64_t offset, exr_stream_error_func_ptr_t error);
    static void error_callback(exr_const_context_t context, exr_result_t code, const char* message);

    std::filesystem::path file_;
    AtomicFile* target_;
    int descriptor_ = -1;
    std::int64_t size_bytes_ = 0;
    exr_context_t context_ = nullptr;
    mutable std::mutex error_mutex_;
    mutable std::string first_error_;
};

}  // namespace equistream
