#pragma once
/// Open Image Denoise (Intel, Apache 2.0), found and loaded while the program runs, so that nothing needs it in order
/// to start. Functions and numbers are those of its C interface, version 2.
#include <cstddef>
#include <memory>
#include <string>

namespace equistream::oidn {

/// Device, buffer and filter: pointers that only the library looks behind.
using Handle = void*;

enum Format { float3 = 3 };
enum Quality { fast = 4, balanced = 5, high = 6 };
enum DeviceType { any_device = 0, cpu = 1 };

/// Null where a file lacks the function; library() refuses such a file.
struct Library {
    Handle (*new_device)(int type) = nullptr;
    void (*set_device_int)(Handle device, const char* name, int value) = nullptr;
    void (*set_device_bool)(Handle device, const char* name, bool value) = nullptr;
    int (*device_int)(Handle device, const char* name) = nullptr;
    void (*commit_device)(Handle device) = nullptr;
    int (*device_error)(Handle device, const char** message) = nullptr;
    void (*release_device)(Handle device) = nullptr;

    Handle (*new_buffer)(Handle device, std::size_t bytes) = nullptr;
    void (*write_buffer)(Handle buffer, std::size_t offset, std::size_t bytes, const void* from) = nullptr;
    void (*read_buffer)(Handle buffer, std::size_t offset, std::size_t bytes, void* to) = nullptr;
    void (*release_buffer)(Handle buffer) = nullptr;

    Handle (*new_filter)(Handle device, const char* type) = nullptr;
    void (*set_filter_image)(Handle filter, const char* name, Handle buffer, int format, std::size_t width,
                             std::size_t height, std::size_t offset, std::size_t pixel_bytes,
                             std::size_t row_bytes) = nullptr;
    void (*set_filter_bool)(Handle filter, const char* name, bool value) = nullptr;
    void (*set_filter_int)(Handle filter, const char* name, int value) = nullptr;
    void (*set_filter_float)(Handle filter, const char* name, float value) = nullptr;
    void (*commit_filter)(Handle filter) = nullptr;
    void (*execute_filter)(Handle filter) = nullptr;
    void (*release_filter)(Handle filter) = nullptr;
};

/// The library, loaded by the first call that finds it; it stays loaded. Looked for in: the file or the folder that
/// EQUISTREAM_OIDN names; the system's libraries; Python's package `pyoidn`, in the environment that is active, beside
/// our own package, in the user's and in the system's. Throws InputError in one line that says how to get it.
const Library& library();

/// A device with its library. Throws InputError for another major version and for a device that cannot be had.
class Device {
public:
    /// The fastest there is, as the library judges (OIDN_DEFAULT_DEVICE overrides it). `threads`: of a CPU; 0: all.
    explicit Device(unsigned threads);

    const Library& functions() const { return library_; }
    Handle handle() const { return handle_.get(); }
    /// "Open Image Denoise 2.5.1", and the kind of device where it is no CPU.
    const std::string& name() const { return name_; }
    /// Throws WorkError "WHAT: ..." where the library has complained since the last call.
    void check(const char* what) const;

private:
    const Library& library_;
    std::unique_ptr<void, void (*)(Handle)> handle_;
    std::string name_;
};

/// One for all that ask for so many threads while it lives: its memory is large.
std::shared_ptr<const Device> shared_device(unsigned threads);

}  // namespace equistream::oidn
