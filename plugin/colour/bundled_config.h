#pragma once
/// The OpenColorIO config that is compiled in, so that no install path is needed.

namespace equistream {

extern const char* const bundled_config_text;

}  // namespace equistream
