// INPUT of the command line: files and standard input, plain and compressed.

#include <fcntl.h>
#include <unistd.h>

#include <functional>
#include <stdexcept>
#include <string>
#include <string_view>
#include <thread>
#include <vector>

#include <bzlib.h>
#include <gtest/gtest.h>
#include <lzma.h>
#include <zlib.h>
#include <zstd.h>

#include <raybundle/models/error.h>
#include <raybundle/tests/support/bal_check.h>
#include <raybundle/tests/support/random_problem.h>
#include <raybundle/tests/support/temporary_folder.h>
#include <raybundle/tools/decompress.h>
#include <raybundle/tools/input.h>

namespace raybundle::tools {
namespace {

using test::same_bits;
using test::TemporaryFolder;
using test::write_text;

std::string gzip(std::string text) {
  std::string packed(text.size() + 1000, '\0');
  z_stream stream{};
  if (::deflateInit2(&stream, 6, Z_DEFLATED, MAX_WBITS + 16, 8, Z_DEFAULT_STRATEGY) != Z_OK) {
    throw std::runtime_error("deflateInit2");
  }
  stream.next_in = reinterpret_cast<Bytef*>(text.data());
  stream.avail_in = static_cast<uInt>(text.size());
  stream.next_out = reinterpret_cast<Bytef*>(packed.data());
  stream.avail_out = static_cast<uInt>(packed.size());
  const int code = ::deflate(&stream, Z_FINISH);
  packed.resize(stream.total_out);
  ::deflateEnd(&stream);
  if (code != Z_STREAM_END) throw std::runtime_error("deflate");
  return packed;
}

std::string bzip2(std::string text) {
  std::string packed(2 * text.size() + 1000, '\0');
  auto size = static_cast<unsigned int>(packed.size());
  if (::BZ2_bzBuffToBuffCompress(packed.data(), &size, text.data(),
                                 static_cast<unsigned int>(text.size()), 1, 0, 0) != BZ_OK) {
    throw std::runtime_error("BZ2_bzBuffToBuffCompress");
  }
  packed.resize(size);
  return packed;
}

std::string xz(const std::string& text) {
  std::string packed(::lzma_stream_buffer_bound(text.size()), '\0');
  std::size_t size = 0;
  if (::lzma_easy_buffer_encode(1, LZMA_CHECK_CRC64, nullptr,
                                reinterpret_cast<const std::uint8_t*>(text.data()), text.size(),
                                reinterpret_cast<std::uint8_t*>(packed.data()), &size,
                                packed.size()) != LZMA_OK) {
    throw std::runtime_error("lzma_easy_buffer_encode");
  }
  packed.resize(size);
  return packed;
}

std::string zstd(const std::string& text) {
  std::string packed(::ZSTD_compressBound(text.size()), '\0');
  const std::size_t size =
      ::ZSTD_compress(packed.data(), packed.size(), text.data(), text.size(), 3);
  if (::ZSTD_isError(size) != 0) throw std::runtime_error("ZSTD_compress");
  packed.resize(size);
  return packed;
}

struct Format {
  const char* name;
  Compression kind;
  std::function<std::string(const std::string&)> pack;
};

constexpr std::int64_t plenty = std::int64_t{1} << 30;

class Compressed : public testing::TestWithParam<Format> {
 protected:
  std::string pack(const std::string& text) const { return GetParam().pack(text); }
  std::string unpack(std::string_view packed, std::int64_t most_bytes = plenty) const {
    return decompress(packed, GetParam().kind, "scene", most_bytes);
  }
  /// The message of the InputError; empty when there is none.
  std::string refusal(std::string_view packed, std::int64_t most_bytes = plenty) const {
    try {
      unpack(packed, most_bytes);
    } catch (const InputError& error) {
      EXPECT_EQ(error.source(), "scene");
      return error.what();
    }
    return "";
  }

  Problem problem_ = test::random_problem(5, 10, 1000, 5000);  // more than one piece
  std::string text_ = test::bal_text(problem_);
};

TEST_P(Compressed, IsToldByItsContentNotItsName) {
  const TemporaryFolder folder;
  write_text(folder / "scene.txt", pack(text_));
  EXPECT_TRUE(same_bits(read_input((folder / "scene.txt").string()), problem_));
  EXPECT_EQ(detect_compression(pack(text_)), GetParam().kind);
  EXPECT_EQ(detect_compression(pack("")), GetParam().kind);
}

TEST_P(Compressed, StreamsMayFollowOneAnother) {
  const std::string packed = pack("") + pack(text_.substr(0, 1000)) + pack(text_.substr(1000, 1)) +
                             pack(text_.substr(1001));
  EXPECT_EQ(unpack(packed), text_);
}

TEST_P(Compressed, CutShortIsRefused) {
  const std::string packed = pack(text_);
  for (const std::size_t size : {packed.size() - 1, packed.size() - 9, packed.size() / 2,
                                 std::size_t{30}, std::size_t{7}, std::size_t{4}}) {
    const std::string message = refusal(std::string_view(packed).substr(0, size));
    EXPECT_NE(message.find("the end of the file within"), std::string::npos)
        << size << ": " << message;
  }
  // Within the second of two.
  EXPECT_NE(refusal(packed + packed.substr(0, packed.size() / 3)), "");
}

TEST_P(Compressed, DamageIsRefusedOrHarmless) {
  const std::string packed = pack(text_);
  int refused = 0;
  constexpr std::size_t places = 24;
  for (std::size_t i = 0; i < places; ++i) {
    std::string damaged = packed;
    damaged[i * (packed.size() - 1) / (places - 1)] ^= 0x10;
    if (detect_compression(damaged) != GetParam().kind) continue;
    if (!refusal(damaged).empty()) ++refused;  // nothing but an InputError may come
  }
  EXPECT_GT(refused, 0);
}

TEST_P(Compressed, SomethingElseAfterItIsRefused) {
  EXPECT_NE(refusal(pack(text_) + "1 2 3").find("found '1 2 3' after"), std::string::npos);
  EXPECT_NE(refusal(pack(text_) + std::string("\0\0\0x", 4)).find("after"), std::string::npos);
}

TEST_P(Compressed, ABombIsDefused) {
  const std::string bomb = pack(std::string(5'000'000, '0'));
  EXPECT_LT(bomb.size(), 50'000U);
  EXPECT_NE(refusal(bomb, 1'000'000).find("unpack to more than 1000000 bytes"), std::string::npos);
  EXPECT_EQ(unpack(pack(std::string(1000, '0')), 1000).size(), 1000U);
}

TEST_P(Compressed, ErrorsHaveTheLineOfTheText) {
  const TemporaryFolder folder;
  const std::string name = (folder / "scene.gz").string();
  write_text(name, pack("1 1 1\n0 0 1 2\n0 0 0 0 0 0 0 0 0\n1 nan 3\n"));
  try {
    read_input(name);
    FAIL() << "was read";
  } catch (const InputError& error) {
    EXPECT_EQ(error.what(),
              name + ":4: found 'nan', expected a finite number, y of point 0 (of 0 to 0)");
  }
}

INSTANTIATE_TEST_SUITE_P(Formats, Compressed,
                         testing::Values(Format{"gzip", Compression::gzip, gzip},
                                         Format{"bzip2", Compression::bzip2, bzip2},
                                         Format{"xz", Compression::xz, xz},
                                         Format{"zstd", Compression::zstd, zstd}),
                         [](const testing::TestParamInfo<Format>& parameter) {
                           return parameter.param.name;
                         });

TEST(Decompress, PaddingAndFramesToSkipAreFine) {
  EXPECT_EQ(decompress(gzip("text") + std::string(512, '\0'), Compression::gzip, "", plenty),
            "text");
  EXPECT_EQ(decompress(xz("text") + std::string(8, '\0'), Compression::xz, "", plenty), "text");
  const std::string skipped("\x5A\x2A\x4D\x18\x03\0\0\0abc", 11);
  EXPECT_EQ(detect_compression(skipped), Compression::zstd);
  const std::string packed = skipped + zstd("te") + skipped + zstd("xt");
  EXPECT_EQ(decompress(packed, Compression::zstd, "", plenty), "text");
}

TEST(Decompress, ADictionaryPromisedTooLargeIsRefused) {
  // A frame header that asks for a window of 2^41 bytes; nothing of that is allocated.
  const std::string frame("\x28\xB5\x2F\xFD\x00\xF8\x01\x00\x00", 9);
  EXPECT_THROW(decompress(frame, Compression::zstd, "scene", plenty), InputError);
}

/// Puts `descriptor` in the place of standard input while it lives.
class StandardInput {
 public:
  explicit StandardInput(int descriptor) : before_(::dup(STDIN_FILENO)) {
    ::dup2(descriptor, STDIN_FILENO);
  }
  ~StandardInput() {
    if (before_ >= 0) {
      ::dup2(before_, STDIN_FILENO);
      ::close(before_);
    } else {
      ::close(STDIN_FILENO);
    }
  }
  StandardInput(const StandardInput&) = delete;
  StandardInput& operator=(const StandardInput&) = delete;

 private:
  int before_;
};

TEST(Input, StandardInputMayBeAPipe) {
  const Problem problem = test::random_problem(6, 10, 5000, 20000);
  const std::string text = test::bal_text(problem);
  for (const std::string& sent : {text, xz(text)}) {
    int ends[2] = {-1, -1};
    ASSERT_EQ(::pipe(ends), 0);
    std::thread writer([&] {
      for (std::size_t at = 0; at < sent.size();) {
        const ssize_t count = ::write(ends[1], sent.data() + at, sent.size() - at);
        if (count <= 0) break;
        at += static_cast<std::size_t>(count);
      }
      ::close(ends[1]);
    });
    Problem read;
    {
      const StandardInput input(ends[0]);
      read = read_input("-");
    }
    writer.join();
    ::close(ends[0]);
    EXPECT_TRUE(same_bits(read, problem));
  }
}

TEST(Input, StandardInputMayBeAFile) {
  const TemporaryFolder folder;
  write_text(folder / "scene", "2 1 1\n");
  const int descriptor = ::open((folder / "scene").c_str(), O_RDONLY | O_CLOEXEC);
  ASSERT_GE(descriptor, 0);
  const StandardInput input(descriptor);
  ::close(descriptor);
  try {
    read_input("-");
    FAIL() << "was read";
  } catch (const InputError& error) {
    EXPECT_EQ(error.source(), "-");
    EXPECT_EQ(error.line(), 1);
  }
}

TEST(Input, AMissingFileIsNamed) {
  try {
    read_input("no/such/file.txt.gz");
    FAIL() << "was read";
  } catch (const InputError& error) {
    EXPECT_EQ(error.source(), "no/such/file.txt.gz");
    EXPECT_EQ(error.found(), "nothing readable (No such file or directory)");
  }
}

}  // namespace
}  // namespace raybundle::tools
