#pragma once
/// Memory that a decoder's pictures come to lie in, of whoever looks at them: a driver's, so that nobody copies them
/// there.
#include <cstddef>
#include <cstdint>
#include <memory>

namespace equistream {

class PictureMemory {
public:
    virtual ~PictureMemory() = default;

    /// At least so many bytes, at a multiple of 64, until the last copy of what is returned goes; null: there are none
    /// just now, and memory of the decoder's own does as well. Decoders read there too what they wrote before. Any
    /// thread, several at once; waits for nobody.
    virtual std::shared_ptr<std::uint8_t> take(std::size_t bytes) = 0;
};

}  // namespace equistream
