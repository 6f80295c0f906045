#pragma once
/// What the colours of an overlay say, beside the picture and in the panel. By Dear ImGui.
#include "content.h"

namespace equistream {

/// Of what is laid over the picture, in the window's lower right corner above `bottom`; nothing where there is none.
void build_legend(const FaceContent& content, float right, float bottom);

/// The same among the panel's own items.
void build_legend_items(const FaceContent& content);

}  // namespace equistream
