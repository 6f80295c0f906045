#pragma once
/// Options on how an HDR stream comes to the display, the same in `play` and `view`.
#include "program.h"

#include <equistream/colour.h>

#include <memory>

namespace equistream {

class HdrOptions {
public:
    void add_to(cli::CommandLine& app);
    /// Null where none was given. Throws InputError.
    std::shared_ptr<const HdrDisplay> display() const;

private:
    HdrDisplaySettings settings_;
    std::vector<cli::Option> options_;
};

}  // namespace equistream
