#include "private_file.h"

#include <equistream/error.h>

#include <fcntl.h>
#include <unistd.h>

#include <cerrno>
#include <cstring>
#include <fstream>

namespace equistream {

namespace {

/// A secret, or a certificate with those that vouch for it, takes less.
constexpr std::size_t max_bytes = 1 << 20;

}  // namespace

bool make_private_file(const std::filesystem::path& file, const std::function<std::string()>& text) {
    const std::string name = file.string();
    const int made = ::open(name.c_str(), O_WRONLY | O_CREAT | O_EXCL | O_CLOEXEC, S_IRUSR | S_IWUSR);
    if (made < 0 && errno == EEXIST)
        return false;
    if (made < 0)
        throw InputError(name + ": cannot be made: " + std::strerror(errno));
    bool is_whole = false;
    try {
        const std::string content = text();
        is_whole = ::write(made, content.data(), content.size()) == ssize_t(content.size());
    } catch (...) {
        ::close(made);
        ::unlink(name.c_str());
        throw;
    }
    if (::close(made) == 0 && is_whole)
        return true;
    ::unlink(name.c_str());
    throw WorkError(name + ": could not be written");
}

std::string read_private_file(const std::filesystem::path& file) {
    std::error_code error;
    const auto open_to_others = std::filesystem::status(file, error).permissions() &
                                (std::filesystem::perms::group_all | std::filesystem::perms::others_all);
    if (open_to_others != std::filesystem::perms::none)
        throw InputError(expected_found(file.string(), "a file that only its owner can access (chmod 600)",
                                        "one that others can access"));
    std::ifstream stream(file, std::ios::binary);
    if (!stream || !std::filesystem::is_regular_file(file, error))
        throw InputError(expected_found(file.string(), "a file that can be read", "none"));
    std::string text(max_bytes, '\0');
    stream.read(text.data(), std::streamsize(text.size()));
    text.resize(std::size_t(stream.gcount()));
    return text;
}

}  // namespace equistream
