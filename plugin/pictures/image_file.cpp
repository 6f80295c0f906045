#include "image_file.h"

namespace equistream {

std::unique_ptr<OIIO::ImageInput> open_image_file(const std::filesystem::path& file, std::string& problem) {
    const std::string name = file.string(), extension = file.extension().string();
    // In a name that tells it the format, OpenImageIO takes what follows a question mark for options.
    const bool has_mark = name.find('?') != std::string::npos && extension.size() > 1;
    auto input = has_mark ? OIIO::ImageInput::create(extension.substr(1)) : OIIO::ImageInput::open(name);
    OIIO::ImageSpec spec;
    if (!input) {
        problem = OIIO::geterror();
    } else if (has_mark && !input->open(name, spec)) {
        problem = input->geterror();
        input.reset();
    }
    return input;
}

}  // namespace equistream
