#pragma once
/// FrameInfo as EXR attributes and back (docs/conventions.md, "EXR files").
#include "exr_session.h"

#include <equistream/frame.h>

namespace equistream {

/// Writes every attribute of `info` to one part; the names appear in every part of a file.
void write_attributes(const ExrSession& session, int part, const FrameInfo& info);

/// Notes in one part that so many colour samples were not finite and are in no pixel's mean.
void write_left_out_samples(const ExrSession& session, int part, std::int64_t count);

/// True for a file of ours: one that carries equistream:version.
bool has_attributes(const ExrSession& session);

/// Reads and checks the first part's attributes; throws InputError naming file and attribute.
FrameInfo read_attributes(const ExrSession& session, int width, int height);

}  // namespace equistream
