#pragma once
/// Both eyes' pictures into the caller's memory.
#include <client/session/session.h>

#include <equistream/client.h>

#include <span>

namespace equistream {

/// Checks what the caller gave for a request of that size, before anything is rendered.
void require_images(std::span<const es_eye_image, 2> images, const SessionRequest& request);

void write_image(const PipelineEye& eye, const ViewPart& part, const SessionRequest& request, es_eye_image& image);

es_field_of_view fov_of(const FieldOfView& fov);

}  // namespace equistream
