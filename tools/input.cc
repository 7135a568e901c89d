#include <raybundle/tools/input.h>

#include <unistd.h>

#include <optional>
#include <string_view>

#include <raybundle/models/io/bal.h>
#include <raybundle/models/io/file_content.h>
#include <raybundle/models/io/parallaxba.h>
#include <raybundle/tools/decompress.h>

namespace raybundle::tools {

Problem read_input(const std::string& input) {
  if (io::is_parallaxba(input)) return io::read_parallaxba(input);
  std::optional<io::FileContent> content;
  if (input == "-") {
    content.emplace(STDIN_FILENO, input);
  } else {
    content.emplace(std::filesystem::path(input));
  }
  const std::string_view bytes = content->text();
  const Compression kind = detect_compression(bytes);
  if (kind == Compression::none) return io::parse_bal(bytes, input);
  const std::string text = decompress(bytes, kind, input, io::largest_stream());
  content.reset();
  return io::parse_bal(text, input);
}

}  // namespace raybundle::tools
