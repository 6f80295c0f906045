#pragma once
/// The plain implementation of the engines: double precision, one pixel after the other, through the public cameras.
#include <equistream_client/engine.h>

namespace equistream {

std::unique_ptr<Engine> make_reference_engine(bool surface, const EngineOptions& options);

}  // namespace equistream
