#include "config.h"

#include "bundled_config.h"

#include <equistream/error.h>

#include <sstream>

namespace equistream {

ocio::ConstConfigRcPtr load_bundled_config() {
    std::istringstream text(bundled_config_text);
    return ocio::Config::CreateFromStream(text);
}

void check_view(const ocio::Config& config, const std::string& display, const std::string& view) {
    std::string accepted;
    for (int i = 0; i < config.getNumViews(display.c_str()); ++i) {
        const std::string name = config.getView(display.c_str(), i);
        if (name == view)
            return;
        accepted += (accepted.empty() ? "" : ", ") + ("\"" + name + "\"");
    }
    throw InputError(expected_found("view", "one of " + accepted, "\"" + view + "\""));
}

ocio::DisplayViewTransformRcPtr display_view(const std::string& from, const std::string& display,
                                             const std::string& view, ocio::TransformDirection direction) {
    auto transform = ocio::DisplayViewTransform::Create();
    transform->setSrc(from.c_str());
    transform->setDisplay(display.c_str());
    transform->setView(view.c_str());
    transform->setDirection(direction);
    return transform;
}

void check_exposure(double exposure) {
    if (!(exposure > 0) || !std::isfinite(exposure))
        throw InputError(expected_found("exposure", "a positive number", std::to_string(exposure)));
}

}  // namespace equistream
