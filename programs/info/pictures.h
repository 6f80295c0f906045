#pragma once
/// Pictures of what a frame carries, for people who would rather look than read.
#include <filesystem>

namespace equistream {

/// Writes FOLDER/frame.NNNN.PLANE.png for every plane of an EXR frame, or of every frame of a sequence's folder. Those
/// of a render's folder go into FOLDER/centre, FOLDER/hidden and so on. Returns how many pictures it wrote.
int write_pictures(const std::filesystem::path& source, const std::filesystem::path& folder);

}  // namespace equistream
