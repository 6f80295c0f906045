#pragma once
/// What callers hand over, checked: every number finite and in range, every text a text. Throws InputError that names
/// the field.
#include <client/session/session.h>
#include <plugin/abi/whole_struct.h>

#include <equistream/client.h>

#include <algorithm>
#include <cstring>
#include <string>

namespace equistream {

struct CheckedSettings {
    SessionSettings session;
    bool by_gl = false;
};

CheckedSettings checked_settings(const es_client_settings* settings);
SessionRequest checked_request(const es_client_request* request);
Pose checked_pose(const std::string& field, const es_pose& pose);
es_pose pose_of(const Pose& pose);

/// Copies what the library has to say into a struct of the caller's, as far as the caller's header has fields. The
/// struct's size stays the caller's. Throws InputError for NULL and for a struct smaller than it ever was.
template <typename Struct>
void fill_struct(Struct* of_caller, const char* name, Struct filled) {
    const std::size_t sizes[] = {sizeof(Struct)};
    filled.struct_size = whole_struct(of_caller, name, sizes).struct_size;
    std::memcpy(of_caller, &filled, std::min(filled.struct_size, sizeof(Struct)));
}

}  // namespace equistream
