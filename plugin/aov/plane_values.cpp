#include <equistream/error.h>
#include <equistream/plane_values.h>

#include <cmath>
#include <string>

namespace equistream {

void require_plane_values(const AovInfo& aov, ImageView<const float> plane) {
    if (aov.name == "colour")
        return;
    const bool is_depth = aov.name == "depth" || aov.name == "virtual_depth";
    for (int y = 0; y < plane.height; ++y) {
        const float* row = plane.row(y);
        for (int i = 0; i < plane.width * plane.channels; ++i)
            if (!(is_depth ? row[i] >= 0 : std::isfinite(row[i])))
                throw InputError(expected_found("plane " + std::string(aov.name) + " at pixel " +
                                                    std::to_string(i / plane.channels) + "," + std::to_string(y),
                                                is_depth ? "a distance, +inf for a miss" : "a finite number",
                                                std::to_string(row[i])));
    }
}

}  // namespace equistream
