#include <raybundle/tools/input.h>

#include <unistd.h>

#include <algorithm>
#include <optional>
#include <string_view>

#include <raybundle/models/error.h>
#include <raybundle/models/io/bal.h>
#include <raybundle/models/io/file_content.h>
#include <raybundle/models/io/parallaxba.h>
#include <raybundle/tools/decompress.h>
#include <raybundle/tools/report.h>

namespace raybundle::tools {
namespace {

/// What parse(text, input) makes of the content of a file or of standard input.
template <class Parse>
Problem parse_content(const std::string& input, const Parse& parse) {
  std::optional<io::FileContent> content;
  if (input == "-") {
    content.emplace(STDIN_FILENO, input);
  } else {
    content.emplace(std::filesystem::path(input));
  }
  const std::string_view bytes = content->text();
  const Compression kind = detect_compression(bytes);
  if (kind == Compression::none) return parse(bytes, input);
  const std::string text = decompress(bytes, kind, input, io::largest_stream());
  content.reset();
  return parse(text, input);
}

/// Numbers, or other words, on the first line that has any.
int words_of_first_line(std::string_view text) {
  constexpr std::string_view white = " \t\r\f\v\n";
  const std::size_t first = text.find_first_not_of(white);
  if (first == std::string_view::npos) return 0;
  std::string_view line = text.substr(first, text.find('\n', first) - first);
  int words = 0;
  while (!line.empty()) {
    line.remove_prefix(std::min(line.find_first_of(white), line.size()));
    line.remove_prefix(std::min(line.find_first_not_of(white), line.size()));
    ++words;
  }
  return words;
}

Problem parse_truth(std::string_view text, const std::string& source) {
  constexpr int header = 3, camera = 6;
  const int words = words_of_first_line(text);
  if (words == header) return io::parse_bal(text, source);
  if (words == camera) return io::parse_parallaxba_cameras(text, source);
  throw InputError(source, 1, count_text(words, "word") + " in the first line",
                   "the header of a BAL file, 3 numbers, or a camera in ParallaxBA's columns, 6");
}

}  // namespace

Problem read_input(const std::string& input, int threads) {
  if (io::is_parallaxba(input)) return io::read_parallaxba(input);
  return parse_content(input, [&](std::string_view text, const std::string& source) {
    return io::parse_bal(text, source, threads);
  });
}

Problem read_truth(const std::string& truth) {
  if (!io::is_parallaxba(truth)) return parse_content(truth, parse_truth);
  return io::read_parallaxba_cameras(io::parallaxba_files(truth).cameras);
}

}  // namespace raybundle::tools
