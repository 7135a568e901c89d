#pragma once

#include <cstddef>
#include <memory>
#include <span>
#include <string_view>

#include <raybundle/tools/decompress.h>

namespace raybundle::tools {

/// One decompression library behind one interface. decode() may take less than it is given and
/// return less than there is room for.
class Decoder {
 public:
  struct Progress {
    std::size_t taken = 0;     ///< bytes of `packed` used up
    std::size_t produced = 0;  ///< bytes written to `room`
    bool finished = false;     ///< the stream ended; what follows needs restart()
  };

  virtual ~Decoder() = default;
  /// Throws std::runtime_error saying what is wrong with the data.
  virtual Progress decode(std::string_view packed, std::span<char> room) = 0;
  /// Ready for the first byte of the next stream.
  virtual void restart() = 0;
};

/// `kind` is not none. Throws std::bad_alloc when the library cannot start.
std::unique_ptr<Decoder> make_decoder(Compression kind);

}  // namespace raybundle::tools
