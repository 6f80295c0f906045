#include "config.h"

#include <equistream/error.h>

#include <clocale>
#include <sstream>

namespace equistream {
namespace {

std::unique_lock<std::mutex> locked() {
    static std::mutex mutex;
    return std::unique_lock(mutex);
}

/// Without a name: one that has a name sets the locale of C functions too.
std::locale plain_locale() {
    return {std::locale::classic(), new std::numpunct<char>};
}

}  // namespace

PlainStreams::PlainStreams() : lock_(locked()) {
    if (std::locale() != std::locale::classic())
        of_host_ = std::locale::global(plain_locale());
}

PlainStreams::~PlainStreams() {
    if (!of_host_)
        return;
    const std::string of_c_functions = std::setlocale(LC_ALL, nullptr);
    std::locale::global(*of_host_);
    std::setlocale(LC_ALL, of_c_functions.c_str());
}

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
