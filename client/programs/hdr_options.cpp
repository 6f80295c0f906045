#include "hdr_options.h"

#include <algorithm>

namespace equistream {

void HdrOptions::add_to(CLI::App& app) {
    options_ = {
        app.add_option("--display", settings_.display,
                       "HDR streams: the display, by its name in the OpenColorIO config; default: sRGB"),
        app.add_option("--view-transform", settings_.view,
                       "HDR streams: how light comes into the display's range, a view of the config; default: "
                       "clipped at white (\"Un-tone-mapped\")"),
        app.add_option("--exposure", settings_.exposure_stops, "HDR streams: stops, -20 to 20, before the view"),
        app.add_option("--ocio", settings_.config,
                       "HDR streams: an OpenColorIO config with its displays and views; default: one built in")
            ->check(CLI::ExistingFile)};
}

std::shared_ptr<const HdrDisplay> HdrOptions::display() const {
    const bool any = std::ranges::any_of(options_, [](const CLI::Option* option) { return option->count() > 0; });
    return any ? std::make_shared<const HdrDisplay>(settings_) : nullptr;
}

}  // namespace equistream
