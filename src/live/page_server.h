// A page and its questions: an HTTP server on 127.0.0.1 for one page of this machine.
//
//   GET  /?token=T       the page
//   GET  /data?token=T   what it shows
//   POST /NAME?token=T   a question: JSON, answered with JSON
//
// A request needs the token of the address and a Host of this server, and its Origin, if it tells
// one, must be this server's page. Nothing is read from the disk. Requests are answered one after
// the other by the thread that calls run().
#pragma once

#include <functional>
#include <memory>
#include <string>

namespace impedraw {

struct PageServerContent {
  std::string page, data;  // HTML, JSON
  // The answer to a question. An InputError is answered as {"error": …} with status 400.
  std::function<std::string(const std::string& name, const std::string& json)> answer;
};

class PageServer {
 public:
  // Listens. port: 0: a free one. Throws InputError if the port cannot be had.
  explicit PageServer(int port);
  ~PageServer();
  PageServer(const PageServer&) = delete;
  PageServer& operator=(const PageServer&) = delete;

  std::string address() const;  // with the token

  // Answers until `ended` says so, which is asked ten times a second.
  void run(const PageServerContent& content, const std::function<bool()>& ended);

 private:
  class Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace impedraw
