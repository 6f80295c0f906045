#pragma once
/// The edge of the C ABI: exceptions become a status and a line of text, structs are taken by their size, and a host's
/// traps for floating-point exceptions stay outside.
#include <equistream/abi_types.h>
#include <equistream/error.h>

#include <algorithm>
#include <cfenv>
#include <cstddef>
#include <cstring>
#include <new>
#include <span>
#include <string>
#include <string_view>
#include <type_traits>

namespace equistream {

inline es_status failed(es_error* error, es_status status, std::string_view text) noexcept {
    if (error == nullptr)
        return status;
    const std::size_t length = std::min(text.size(), sizeof error->text - 1);
    std::transform(text.begin(), text.begin() + std::ptrdiff_t(length), error->text, [](char c) {
        if (c == '\n')
            return ' ';
        return static_cast<unsigned char>(c) < 0x20 || c == 0x7f ? '?' : c;  // a name's, for a terminal
    });
    error->text[length] = '\0';
    return status;
}

/// While it lives, floating-point exceptions end nothing in this thread, nor in those that it starts. Some hosts have
/// them do so (feenableexcept), and libraries divide by zero and go on with infinity.
class NoTraps {
public:
    NoTraps() { std::feholdexcept(&of_host_); }
    ~NoTraps() { std::fesetenv(&of_host_); }
    NoTraps(const NoTraps&) = delete;
    NoTraps& operator=(const NoTraps&) = delete;

private:
    std::fenv_t of_host_{};
};

template <typename Work>
es_status guarded(es_error* error, Work work) noexcept {
    const NoTraps no_traps;
    try {
        work();
        return ES_OK;
    } catch (const InputError& problem) {
        return failed(error, ES_BAD_INPUT, problem.what());
    } catch (const std::bad_alloc&) {
        return failed(error, ES_FAILED, "out of memory");
    } catch (const std::exception& problem) {
        return failed(error, ES_FAILED, problem.what());
    } catch (...) {
        return failed(error, ES_FAILED, "unknown error");
    }
}

// Structs that grow: a caller built with an older header hands over a shorter one.

/// The struct with 0 where the host's header had no field yet; what a later header than ours appended is ignored.
/// Throws InputError for NULL and for a struct shorter than it ever was.
template <typename Struct>
Struct whole_struct(const Struct* of_host, const char* name, std::span<const std::size_t> sizes) {
    static_assert(std::is_trivially_copyable_v<Struct>);
    if (of_host == nullptr)
        throw InputError(expected_found(name, "a pointer", "NULL"));
    std::size_t size = 0;
    std::memcpy(&size, of_host, sizeof size);  // every one of them begins with its size
    std::size_t known = 0;
    for (const std::size_t each : sizes)
        if (each <= size)
            known = each;
    if (known == 0)
        throw InputError(expected_found(std::string(name) + ".struct_size", "at least " + std::to_string(sizes.front()),
                                        std::to_string(size)));
    Struct whole{};
    std::memcpy(&whole, of_host, known);
    return whole;
}

}  // namespace equistream
