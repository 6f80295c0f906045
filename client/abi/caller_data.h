#pragma once
/// What callers hand over, checked: every number finite and in range, every text a text. Throws InputError that names
/// the field.
#include <equistream/client.h>

#include <client/session/session.h>
#include <plugin/abi/boundary.h>

#include <algorithm>
#include <cstring>
#include <span>
#include <string>

namespace equistream {

SessionSettings checked_settings(const es_client_settings* settings);
SessionRequest checked_request(const es_client_request* request);
Pose checked_pose(const std::string& field, const es_pose& pose);

/// Checks what will be filled, before anything is done. Throws InputError for NULL and for a struct smaller than it
/// ever was.
template <typename Struct>
void require_struct(const Struct* of_caller, const char* name) {
    const std::size_t sizes[] = {sizeof(Struct)};
    whole_struct(of_caller, name, sizes);
}

/// Structs that a call takes two of do not grow: the second one lies where the first one's size says.
void require_exact_size(const std::string& name, std::size_t expected, std::size_t found);

/// Copies what the library has to say into a struct of the caller's, as far as the caller's header has fields. The
/// struct's size stays the caller's. Throws InputError for NULL and for a struct smaller than it ever was.
template <typename Struct>
void fill_struct(Struct* of_caller, const char* name, Struct filled) {
    const std::size_t sizes[] = {sizeof(Struct)};
    filled.struct_size = whole_struct(of_caller, name, sizes).struct_size;
    std::memcpy(of_caller, &filled, std::min(filled.struct_size, sizeof(Struct)));
}

// Both eyes' pictures into the caller's memory.

/// Checks what the caller gave for a request of that size, before anything is rendered.
void require_images(std::span<const es_eye_image, 2> images, const SessionRequest& request);

/// `part` is no larger than what was asked for.
void write_image(const PipelineEye& eye, const ViewPart& part, const SessionRequest& request, es_eye_image& image);

es_field_of_view fov_of(const FieldOfView& fov);

}  // namespace equistream
