#include "oidn.h"

#include <equistream/error.h>

#include <dlfcn.h>

#include <algorithm>
#include <cstdlib>
#include <filesystem>
#include <map>
#include <mutex>
#include <optional>
#include <vector>

namespace equistream::oidn {
namespace {

namespace fs = std::filesystem;

constexpr const char* file_name = "libOpenImageDenoise.so.2";
constexpr const char* in_package = "pyoidn/oidn/lib/libOpenImageDenoise.so.2";
constexpr const char* expected = "Open Image Denoise 2 (pip install pyoidn, or its file's name in EQUISTREAM_OIDN)";
constexpr const char* device_of_theirs = "a device of Open Image Denoise's";
constexpr int major_version = 2;

fs::path environment(const char* name) {
    const char* value = std::getenv(name);
    return value == nullptr ? "" : value;
}

/// Where `prefix`/lib/pythonX.Y holds packages.
void add_packages_of(const fs::path& prefix, std::vector<fs::path>& folders) {
    if (prefix.empty())
        return;
    std::error_code error;
    for (const fs::directory_entry& entry : fs::directory_iterator(prefix / "lib", error))
        if (entry.path().filename().string().starts_with("python3"))
            for (const char* packages : {"site-packages", "dist-packages"})
                folders.push_back(entry.path() / packages);
}

/// Of the file that this code is in: beside it in a Python environment.
fs::path own_file() {
    Dl_info info{};
    return dladdr(reinterpret_cast<const void*>(&own_file), &info) != 0 ? fs::path(info.dli_fname) : fs::path();
}

std::vector<std::string> candidates() {
    std::vector<fs::path> folders;
    add_packages_of(environment("VIRTUAL_ENV"), folders);
    for (fs::path folder = own_file().parent_path(); folder != folder.parent_path(); folder = folder.parent_path())
        folders.push_back(folder);
    const fs::path home = environment("HOME");
    add_packages_of(home.empty() ? home : home / ".local", folders);
    add_packages_of("/usr/local", folders);
    folders.emplace_back("/usr/lib/python3/dist-packages");
    add_packages_of(EQUISTREAM_PYTHON_PREFIX, folders);
    std::vector<std::string> files{file_name};  // by the system's own search
    std::error_code error;
    for (const fs::path& folder : folders)
        if (fs::exists(folder / in_package, error))
            files.push_back((folder / in_package).string());
    return files;
}

/// The file's functions, or what one is missing.
class Loaded {
public:
    explicit Loaded(void* file) : file_(file) {
        get("oidnNewDevice", library.new_device);
        get("oidnSetDeviceInt", library.set_device_int);
        get("oidnSetDeviceBool", library.set_device_bool);
        get("oidnGetDeviceInt", library.device_int);
        get("oidnCommitDevice", library.commit_device);
        get("oidnGetDeviceError", library.device_error);
        get("oidnReleaseDevice", library.release_device);
        get("oidnNewBuffer", library.new_buffer);
        get("oidnWriteBuffer", library.write_buffer);
        get("oidnReadBuffer", library.read_buffer);
        get("oidnReleaseBuffer", library.release_buffer);
        get("oidnNewFilter", library.new_filter);
        get("oidnSetFilterImage", library.set_filter_image);
        get("oidnSetFilterBool", library.set_filter_bool);
        get("oidnSetFilterInt", library.set_filter_int);
        get("oidnSetFilterFloat", library.set_filter_float);
        get("oidnCommitFilter", library.commit_filter);
        get("oidnExecuteFilter", library.execute_filter);
        get("oidnReleaseFilter", library.release_filter);
    }

    Library library;
    std::string missing;

private:
    template <typename Function>
    void get(const char* name, Function& function) {
        function = reinterpret_cast<Function>(dlsym(file_, name));
        if (function == nullptr && missing.empty())
            missing = name;
    }
    void* file_;
};

/// Local: its TBB, where it brings one, is nobody else's.
void* open(const std::string& file) {
    return dlopen(file.c_str(), RTLD_NOW | RTLD_LOCAL);
}

void* open_any() {
    if (fs::path given = environment("EQUISTREAM_OIDN"); !given.empty()) {
        std::error_code error;
        if (fs::is_directory(given, error))
            given /= file_name;
        void* const file = open(given.string());
        if (file == nullptr)
            throw InputError(expected_found("EQUISTREAM_OIDN", "Open Image Denoise's library or its folder",
                                            std::string(dlerror())));
        return file;
    }
    std::string unusable;
    for (const std::string& candidate : candidates()) {
        if (void* const file = open(candidate))
            return file;
        const char* const why = dlerror();
        std::error_code error;
        if (unusable.empty() && why != nullptr && fs::exists(candidate, error))
            unusable = why;
    }
    throw InputError(expected_found("denoise", expected, unusable.empty() ? "none" : unusable));
}

}  // namespace

const Library& library() {
    static std::mutex mutex;
    static std::optional<Library> found;
    const std::lock_guard lock(mutex);
    if (found)
        return *found;
    const Loaded loaded(open_any());
    if (!loaded.missing.empty())
        throw InputError(expected_found("denoise", expected, "a library without " + loaded.missing));
    found = loaded.library;
    return *found;
}

namespace {

/// "2.5.1" of 20501.
std::string version_text(int version) {
    return std::to_string(version / 10000) + "." + std::to_string(version / 100 % 100) + "." +
           std::to_string(version % 100);
}

const char* kind_of(int type) {
    constexpr const char* kinds[] = {"default", "cpu", "sycl", "cuda", "hip", "metal"};
    return type >= 0 && type < static_cast<int>(std::size(kinds)) ? kinds[type] : "unknown";
}

/// The library takes another device, without a word, where the wanted one is not there.
void require_wanted(int type) {
    const std::string wanted = environment("OIDN_DEFAULT_DEVICE").string();
    const bool is_number = wanted.find_first_not_of("0123456789") == std::string::npos;  // of a device; or nothing
    if (!is_number && wanted != kind_of(any_device) && wanted != kind_of(type))
        throw InputError(expected_found("OIDN_DEFAULT_DEVICE",
                                        "an available device, such as " + std::string(kind_of(type)), wanted));
}

}  // namespace

Device::Device(unsigned threads)
    : library_(library()), handle_(library_.new_device(any_device), library_.release_device) {
    const auto complaint = [&] {
        const char* message = nullptr;
        const int error = library_.device_error(handle(), &message);
        return error == 0 ? std::string() : message == nullptr ? "an error" : message;
    };
    const auto require = [](bool right, const std::string& wanted, const std::string& found) {
        if (!right)
            throw InputError(expected_found("denoise", wanted, found));
    };
    require(handle_ != nullptr, device_of_theirs, complaint());
    const int version = library_.device_int(handle(), "version");
    require(version / 10000 == major_version, expected, "version " + version_text(version));
    const int type = library_.device_int(handle(), "type");
    require_wanted(type);
    if (type == cpu) {
        library_.set_device_int(handle(), "numThreads", static_cast<int>(threads));
        library_.set_device_bool(handle(), "setAffinity", false);  // the renderer's threads share these processors
    }
    library_.commit_device(handle());
    const std::string problem = complaint();
    require(problem.empty(), device_of_theirs, problem);
    name_ = "Open Image Denoise " + version_text(version);
    if (type != cpu)
        name_ += std::string(" on ") + kind_of(type);
}

void Device::check(const char* what) const {
    const char* message = nullptr;
    if (library_.device_error(handle(), &message) != 0)
        throw WorkError(std::string(what) +
                        ": Open Image Denoise: " + quotable(message == nullptr ? "an error" : message, 300));
}

std::shared_ptr<const Device> shared_device(unsigned threads) {
    static std::mutex mutex;
    static std::map<unsigned, std::weak_ptr<const Device>> devices;
    const std::lock_guard lock(mutex);
    std::shared_ptr<const Device> device = devices[threads].lock();
    if (!device)
        devices[threads] = device = std::make_shared<const Device>(threads);
    return device;
}

}  // namespace equistream::oidn
