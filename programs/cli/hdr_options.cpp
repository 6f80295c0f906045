#include "hdr_options.h"

#include <equistream/error.h>

#include <algorithm>
#include <string>
#include <string_view>
#include <utility>

namespace equistream {

void HdrOptions::add_to(cli::CommandLine& app) {
    options_ = {
        app.add_option("--display", settings_.display,
                       "HDR streams: the display, by its name in the OpenColorIO config; default: sRGB"),
        app.add_option("--view-transform", settings_.view,
                       "HDR streams: the view transform (tone mapping), by its name in the config; default: "
                       "clipped at white (\"Un-tone-mapped\")"),
        app.add_option("--exposure", settings_.exposure_stops, "HDR streams: stops, -20 to 20, before the view"),
        app.add_option("--ocio", settings_.config,
                       "HDR streams: an OpenColorIO config with its displays and views; default: one built in")
            .existing_file()};
}

namespace {

/// What HdrDisplay says of a setting, said of the option that sets it.
std::string of_option(const std::string& message) {
    for (const auto& [setting, option] :
         {std::pair{"display: ", "--display: "}, {"view: ", "--view-transform: "}, {"exposure: ", "--exposure: "}})
        if (message.starts_with(setting))
            return option + message.substr(std::string_view(setting).size());
    return message;
}

}  // namespace

std::shared_ptr<const HdrDisplay> HdrOptions::display() const {
    if (std::ranges::none_of(options_, [](const cli::Option& option) { return option.is_given(); }))
        return nullptr;
    try {
        return std::make_shared<const HdrDisplay>(settings_);
    } catch (const InputError& error) {
        throw InputError(of_option(error.what()));
    }
}

}  // namespace equistream
