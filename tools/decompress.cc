#include <raybundle/tools/decompress.h>

#include <algorithm>
#include <memory>
#include <stdexcept>
#include <vector>

#include <raybundle/models/error.h>
#include <raybundle/models/io/text_reader.h>
#include <raybundle/tools/decoder.h>

namespace raybundle::tools {
namespace {

const char* name_of(Compression kind) {
  switch (kind) {
    case Compression::gzip:
      return "gzip";
    case Compression::bzip2:
      return "bzip2";
    case Compression::xz:
      return "xz";
    case Compression::zstd:
      return "zstd";
    case Compression::none:
      break;
  }
  return "no";
}

bool is_zstd(std::string_view bytes) {
  // The second: a frame to be skipped, which some writers put first.
  return bytes.starts_with("\x28\xB5\x2F\xFD") ||
         (bytes.size() >= 4 && (static_cast<unsigned char>(bytes[0]) & 0xF0) == 0x50 &&
          bytes.substr(1).starts_with("\x2A\x4D\x18"));
}

/// The end, or the zeros that gzip and xz allow after their streams (files on tape were padded so).
bool is_end(std::string_view bytes, Compression kind) {
  if (bytes.empty()) return true;
  return (kind == Compression::gzip || kind == Compression::xz) &&
         std::all_of(bytes.begin(), bytes.end(), [](char c) { return c == '\0'; });
}

}  // namespace

Compression detect_compression(std::string_view bytes) {
  using std::string_view_literals::operator""sv;
  if (bytes.starts_with("\x1F\x8B")) return Compression::gzip;
  if (bytes.starts_with("BZh")) return Compression::bzip2;
  if (bytes.starts_with("\xFD\x37\x7A\x58\x5A\x00"sv)) return Compression::xz;
  if (is_zstd(bytes)) return Compression::zstd;
  return Compression::none;
}

std::string decompress(std::string_view packed, Compression kind, const std::string& source,
                       std::int64_t most_bytes) {
  const std::string data = std::string(name_of(kind)) + " data";
  constexpr std::size_t room = std::size_t{1} << 18;
  const std::unique_ptr<Decoder> decoder = make_decoder(kind);
  std::vector<char> piece(room);
  std::string text;
  while (true) {
    Decoder::Progress progress;
    try {
      progress = decoder->decode(packed, piece);
    } catch (const std::runtime_error& error) {
      throw InputError(source, 0, "damaged " + data + " (" + error.what() + ")", "intact " + data);
    }
    text.append(piece.data(), progress.produced);
    packed.remove_prefix(progress.taken);
    if (static_cast<std::int64_t>(text.size()) > most_bytes) {
      throw InputError(source, 0,
                       data + " that unpack to more than " + std::to_string(most_bytes) + " bytes",
                       "fewer");
    }
    if (progress.finished) {
      if (is_end(packed, kind)) return text;
      if (detect_compression(packed) != kind) {
        throw InputError(source, 0, io::quoted(packed) + " after " + data, "the end of the file");
      }
      decoder->restart();
    } else if (progress.taken == 0 && progress.produced == 0) {
      throw InputError(source, 0, "the end of the file within " + data, "the rest of them");
    }
  }
}

}  // namespace raybundle::tools
