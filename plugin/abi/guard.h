#pragma once
/// Keeps exceptions on our side of the C ABI: they become a status and one line of text.
#include <equistream/abi_types.h>
#include <equistream/error.h>

#include <algorithm>
#include <cstring>
#include <new>
#include <string_view>

namespace equistream {

inline es_status failed(es_error* error, es_status status, std::string_view text) noexcept {
    if (error == nullptr)
        return status;
    const std::size_t length = std::min(text.size(), sizeof error->text - 1);
    std::memcpy(error->text, text.data(), length);
    error->text[length] = '\0';
    std::replace(error->text, error->text + length, '\n', ' ');
    return status;
}

template <typename Work>
es_status guarded(es_error* error, Work work) noexcept {
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

}  // namespace equistream
