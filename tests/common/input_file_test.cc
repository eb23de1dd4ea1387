// Opening what a user names: files that are none are refused before anything is read of them.
#include "impedraw/common/input_file.h"

#include <sys/socket.h>
#include <sys/stat.h>
#include <sys/un.h>

#include <gmock/gmock.h>

#include "scratch_folder.h"

namespace impedraw {
namespace {

using ::testing::HasSubstr;

class InputFileTest : public ScratchFolder {
 protected:
  static std::string refusal(const std::filesystem::path& file) {
    try {
      InputFile{file};
    } catch (const InputError& error) {
      return error.what();
    }
    return "accepted";
  }
};

TEST_F(InputFileTest, ReadsUpToTheBound) {
  const std::string text(3'000'000, 'x');
  const auto file = write("long", text);
  EXPECT_EQ(InputFile(file).size(), text.size());
  EXPECT_EQ(InputFile(file).read(10'000'000), text);
  EXPECT_EQ(InputFile(file).read(text.size()), text);
  EXPECT_EQ(InputFile(file).read(7), "xxxxxxx");
  EXPECT_EQ(InputFile(write("empty", "")).read(7), "");
  EXPECT_THAT(InputFile("/proc/self/status").read(100000), HasSubstr("Pid:"));  // of size 0
}

// Without O_NONBLOCK the pipe would block open() for ever.
TEST_F(InputFileTest, OnlyRegularFiles) {
  const std::string pipe = folder_ / "pipe";
  ASSERT_EQ(mkfifo(pipe.c_str(), 0600), 0);
  EXPECT_EQ(refusal(pipe), pipe + ": is a pipe, must be a regular file");
  EXPECT_EQ(refusal(folder_), folder_.string() + ": is a folder, must be a regular file");
  EXPECT_EQ(refusal("/dev/zero"), "/dev/zero: is a socket or a device, must be a regular file");
  EXPECT_EQ(refusal(folder_ / "none"), (folder_ / "none").string() + ": no such file");
  EXPECT_EQ(refusal(write("file", "") / "x"), (folder_ / "file/x").string() + ": no such file");

  const std::string name = folder_ / "socket";
  const int listening = socket(AF_UNIX, SOCK_STREAM, 0);
  sockaddr_un address{};
  address.sun_family = AF_UNIX;
  ASSERT_LT(name.size(), sizeof address.sun_path);
  name.copy(address.sun_path, name.size());
  ASSERT_EQ(bind(listening, reinterpret_cast<sockaddr*>(&address), sizeof address), 0);
  EXPECT_EQ(refusal(name), name + ": is a socket or a device, must be a regular file");
  close(listening);
}

}  // namespace
}  // namespace impedraw
