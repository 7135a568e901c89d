#include <raybundle/models/error.h>

#include <utility>

namespace raybundle {
namespace {

std::string message(const std::string& source, std::int64_t line, const std::string& found,
                    const std::string& expected) {
  std::string text = source;
  if (line > 0) text += ":" + std::to_string(line);
  return text + ": found " + found + ", expected " + expected;
}

}  // namespace

InputError::InputError(std::string source, std::int64_t line, std::string found,
                       std::string expected)
    : std::runtime_error(message(source, line, found, expected)),
      source_(std::move(source)),
      line_(line),
      found_(std::move(found)),
      expected_(std::move(expected)) {}

}  // namespace raybundle
