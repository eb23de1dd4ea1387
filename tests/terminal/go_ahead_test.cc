// A made-up terminal answers.
#include "impedraw/terminal/go_ahead.h"

#include <gtest/gtest.h>
#include <pty.h>
#include <unistd.h>

#include <csignal>

namespace impedraw {
namespace {

// Standard input and error are a terminal, whose keyboard is `master`.
class Terminal {
 public:
  Terminal() : in_(dup(STDIN_FILENO)), error_(dup(STDERR_FILENO)) {
    int slave = -1;
    EXPECT_EQ(openpty(&master, &slave, nullptr, nullptr, nullptr), 0);
    dup2(slave, STDIN_FILENO);
    dup2(slave, STDERR_FILENO);
    close(slave);
  }
  ~Terminal() {
    std::fflush(stderr);
    dup2(in_, STDIN_FILENO);
    dup2(error_, STDERR_FILENO);
    close(in_);
    close(error_);
    close(master);
  }
  void type(const char* keys) const {
    EXPECT_GT(write(master, keys, std::char_traits<char>::length(keys)), 0);
  }
  int master = -1;

 private:
  int in_, error_;
};

bool given_soon(GoAhead& person) {
  for (int i = 0; i < 200; ++i) {
    if (person.given()) return true;
    usleep(5000);
  }
  return false;
}

TEST(GoAhead, EnterAnswersOnceAndWhatWasTypedBeforeDoesNot) {
  const Terminal terminal;
  GoAhead person;
  ASSERT_TRUE(person.terminal());
  terminal.type("\n");
  usleep(20000);
  EXPECT_FALSE(person.given()) << "nobody was asked";
  person.ask("put in the blue pen");
  EXPECT_TRUE(person.asked());
  EXPECT_FALSE(person.given());
  terminal.type("\n");
  EXPECT_TRUE(given_soon(person));
  EXPECT_FALSE(person.asked());
  EXPECT_FALSE(person.given());
}

TEST(GoAhead, ASignalAnswersWithoutATerminal) {
  struct sigaction before {};
  sigaction(SIGUSR1, nullptr, &before);
  {
    GoAhead person;
    raise(SIGUSR1);  // before it was asked for: no answer
    person.ask("put in the blue pen");
    EXPECT_FALSE(person.given());
    raise(SIGUSR1);
    EXPECT_TRUE(person.given());
    person.ask("and the red one");
    person.withdraw();
    raise(SIGUSR1);
    EXPECT_FALSE(person.given());
  }
  struct sigaction after {};
  sigaction(SIGUSR1, nullptr, &after);
  EXPECT_EQ(before.sa_handler, after.sa_handler);
}

}  // namespace
}  // namespace impedraw
