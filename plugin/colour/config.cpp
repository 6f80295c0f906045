#include "config.h"

#include <equistream/error.h>

#include <sstream>

namespace equistream {

ocio::ConstConfigRcPtr load_bundled_config() {
    std::istringstream text(bundled_config_text());
    return ocio::Config::CreateFromStream(text);
}

void check_name(const char* what, const std::string& name, int count, const std::function<const char*(int)>& name_at) {
    std::string accepted;
    for (int i = 0; i < count; ++i) {
        const std::string known = name_at(i);
        if (known == name)
            return;
        accepted += (accepted.empty() ? "" : ", ") + ("\"" + known + "\"");
    }
    throw InputError(expected_found(what, "one of " + accepted, "\"" + name + "\""));
}

void check_view(const ocio::Config& config, const std::string& display, const std::string& view) {
    check_name("view", view, config.getNumViews(display.c_str()),
               [&](int i) { return config.getView(display.c_str(), i); });
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
