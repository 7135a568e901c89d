#include <raybundle/tools/decoder.h>

#include <algorithm>
#include <cstdint>
#include <new>
#include <stdexcept>
#include <string>
#include <type_traits>

#include <bzlib.h>
#include <lzma.h>
#include <zlib.h>
#include <zstd.h>

namespace raybundle::tools {
namespace {

/// zlib and libbz2 count bytes in 32 bits.
unsigned int clamped(std::size_t size) {
  return static_cast<unsigned int>(std::min(size, std::size_t{1} << 30));
}

class GzipDecoder final : public Decoder {
 public:
  GzipDecoder() {
    constexpr int gzip_only = 16;
    if (::inflateInit2(&stream_, MAX_WBITS + gzip_only) != Z_OK) throw std::bad_alloc();
  }
  ~GzipDecoder() override { ::inflateEnd(&stream_); }

  Progress decode(std::string_view packed, std::span<char> room) override {
    const unsigned int given = clamped(packed.size());
    const unsigned int space = clamped(room.size());
    // The library does not write to its input; its interface is older than const.
    stream_.next_in = reinterpret_cast<Bytef*>(const_cast<char*>(packed.data()));
    stream_.avail_in = given;
    stream_.next_out = reinterpret_cast<Bytef*>(room.data());
    stream_.avail_out = space;
    const int code = ::inflate(&stream_, Z_NO_FLUSH);
    if (code == Z_MEM_ERROR) throw std::bad_alloc();
    if (code != Z_OK && code != Z_STREAM_END && code != Z_BUF_ERROR) {
      throw std::runtime_error(stream_.msg != nullptr ? stream_.msg : "not a gzip stream");
    }
    return {given - stream_.avail_in, space - stream_.avail_out, code == Z_STREAM_END};
  }

  void restart() override { ::inflateReset(&stream_); }

 private:
  z_stream stream_{};
};

class Bzip2Decoder final : public Decoder {
 public:
  Bzip2Decoder() { start(); }
  ~Bzip2Decoder() override { ::BZ2_bzDecompressEnd(&stream_); }

  Progress decode(std::string_view packed, std::span<char> room) override {
    const unsigned int given = clamped(packed.size());
    const unsigned int space = clamped(room.size());
    stream_.next_in = const_cast<char*>(packed.data());
    stream_.avail_in = given;
    stream_.next_out = room.data();
    stream_.avail_out = space;
    const int code = ::BZ2_bzDecompress(&stream_);
    if (code == BZ_MEM_ERROR) throw std::bad_alloc();
    if (code != BZ_OK && code != BZ_STREAM_END) throw std::runtime_error("wrong checksum or code");
    return {given - stream_.avail_in, space - stream_.avail_out, code == BZ_STREAM_END};
  }

  void restart() override {
    ::BZ2_bzDecompressEnd(&stream_);
    start();
  }

 private:
  void start() {
    stream_ = bz_stream{};
    if (::BZ2_bzDecompressInit(&stream_, 0, 0) != BZ_OK) throw std::bad_alloc();
  }

  bz_stream stream_{};
};

class XzDecoder final : public Decoder {
 public:
  XzDecoder() { restart(); }
  ~XzDecoder() override { ::lzma_end(&stream_); }

  Progress decode(std::string_view packed, std::span<char> room) override {
    stream_.next_in = reinterpret_cast<const std::uint8_t*>(packed.data());
    stream_.avail_in = packed.size();
    stream_.next_out = reinterpret_cast<std::uint8_t*>(room.data());
    stream_.avail_out = room.size();
    const lzma_ret code = ::lzma_code(&stream_, LZMA_RUN);
    if (code == LZMA_MEM_ERROR) throw std::bad_alloc();
    if (code == LZMA_MEMLIMIT_ERROR) throw std::runtime_error("a dictionary of more than 1 GiB");
    if (code != LZMA_OK && code != LZMA_STREAM_END && code != LZMA_BUF_ERROR) {
      throw std::runtime_error("wrong checksum or code");
    }
    return {packed.size() - stream_.avail_in, room.size() - stream_.avail_out,
            code == LZMA_STREAM_END};
  }

  void restart() override {
    constexpr std::uint64_t most_memory = std::uint64_t{1}
                                          << 30;  // a header chooses the dictionary
    if (::lzma_stream_decoder(&stream_, most_memory, 0) != LZMA_OK) throw std::bad_alloc();
  }

 private:
  lzma_stream stream_ = LZMA_STREAM_INIT;
};

class ZstdDecoder final : public Decoder {
 public:
  ZstdDecoder() : stream_(::ZSTD_createDStream()) {
    if (stream_ == nullptr) throw std::bad_alloc();
  }
  ~ZstdDecoder() override { ::ZSTD_freeDStream(stream_); }

  Progress decode(std::string_view packed, std::span<char> room) override {
    ZSTD_inBuffer in{packed.data(), packed.size(), 0};
    ZSTD_outBuffer out{room.data(), room.size(), 0};
    const std::size_t code = ::ZSTD_decompressStream(stream_, &out, &in);
    if (::ZSTD_isError(code) != 0) throw std::runtime_error(::ZSTD_getErrorName(code));
    return {in.pos, out.pos, code == 0};
  }

  void restart() override { ::ZSTD_DCtx_reset(stream_, ZSTD_reset_session_only); }

 private:
  ZSTD_DStream* stream_;
};

}  // namespace

std::unique_ptr<Decoder> make_decoder(Compression kind) {
  switch (kind) {
    case Compression::gzip:
      return std::make_unique<GzipDecoder>();
    case Compression::bzip2:
      return std::make_unique<Bzip2Decoder>();
    case Compression::xz:
      return std::make_unique<XzDecoder>();
    case Compression::zstd:
      return std::make_unique<ZstdDecoder>();
    case Compression::none:
      break;
  }
  throw std::invalid_argument("not compressed");
}

}  // namespace raybundle::tools
