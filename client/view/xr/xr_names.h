#pragma once
/// Names of what OpenXR answers.
#include <openxr/openxr.h>
#include <openxr/openxr_reflection.h>

#include <string>

namespace equistream::xr {

/// "XR_ERROR_...".
inline std::string name_of(XrResult result) {
    switch (result) {
#define EQUISTREAM_XR_NAME(name, value)                                                                                \
    case name:                                                                                                         \
        return #name;
        XR_LIST_ENUM_XrResult(EQUISTREAM_XR_NAME)
#undef EQUISTREAM_XR_NAME
    }
    return std::to_string(int(result));
}

}  // namespace equistream::xr
