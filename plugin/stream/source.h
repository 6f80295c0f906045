#pragma once
/// Opening what is to be read: a file or URL, treated as hostile.
#include "libav.h"

#include <functional>
#include <string>

namespace equistream {

/// Throws InputError for what is no video; playlists are refused. `interrupted` may be empty and must outlive what is
/// returned.
av::Demuxer open_source(const std::string& source, const std::function<bool()>& interrupted);

}  // namespace equistream
