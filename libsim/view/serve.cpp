#include "libsim/view/serve.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <boost/asio/ip/tcp.hpp>
#include <boost/asio/steady_timer.hpp>
#include <boost/beast/core.hpp>
#include <boost/beast/http.hpp>
#include <chrono>
#include <memory>
#include <random>
#include <stdexcept>
#include <string_view>

#include "libsim/run/output_folder.hpp"
#include "libsim/view/page.hpp"
#include "libsim/view/view.hpp"

namespace subsoil::sim {
namespace {

namespace asio = boost::asio;
namespace http = boost::beast::http;
using Clock = std::chrono::steady_clock;
using Request = http::request<http::empty_body>;  // a body, which a GET has not, ends the connection
using Answer = http::response<http::string_body>;

std::string random_token() {
  std::random_device source;  // of the system, not seeded
  std::string out;
  for (int k = 0; k < 4; ++k) out += fmt::format("{:08x}", source());
  return out;
}

/// Value of a query's first parameter of this name; empty: none. Numbers and stamps need no decoding.
std::string parameter(std::string_view query, const std::string& name) {
  while (!query.empty()) {
    const std::string_view pair = query.substr(0, query.find('&'));
    query.remove_prefix(std::min(query.size(), pair.size() + 1));
    if (pair.starts_with(name + "=")) return std::string(pair.substr(name.size() + 1));
  }
  return {};
}

/// What is answered to whom. Knows no connection.
class RunPages {
 public:
  RunPages(const std::filesystem::path& run, int port) : run_(run), port_(port), token_(random_token()) {}

  std::string address() const { return fmt::format("http://127.0.0.1:{}/{}/", port_, token_); }

  Answer answer(const Request& asked) {
    Answer out(http::status::not_found, asked.version());
    out.keep_alive(asked.keep_alive());
    out.set(http::field::cache_control, "no-store");
    out.set("Referrer-Policy", "no-referrer");
    out.set("X-Content-Type-Options", "nosniff");
    out.set("Content-Security-Policy",
            "default-src 'none'; script-src 'unsafe-inline'; style-src 'unsafe-inline'; img-src data: blob:; "
            "media-src blob:; connect-src 'self'");
    if (known(asked)) fill(out, asked);
    out.prepare_payload();
    return out;
  }
  /// Who asks knows the token, by a name of this machine, and wants to read.
  bool known(const Request& asked) const {
    const std::string_view host = view(asked[http::field::host]);
    const bool ours = host == fmt::format("127.0.0.1:{}", port_) || host == fmt::format("localhost:{}", port_);
    return ours && asked.method() == http::verb::get && view(asked.target()).starts_with("/" + token_ + "/");
  }

 private:
  template <class Text>
  static std::string_view view(const Text& text) {
    return {text.data(), text.size()};
  }
  void fill(Answer& out, const Request& asked) {
    const std::string_view rest = view(asked.target()).substr(token_.size() + 1);
    const std::string_view path = rest.substr(0, rest.find('?'));
    const std::string_view query = rest.substr(std::min(rest.size(), path.size() + 1));
    try {
      if (path == "/") {
        out.set(http::field::content_type, "text/html; charset=utf-8");
        out.body() = scene_page(run_.scene());
      } else if (path == "/frame") {
        out.set(http::field::content_type, "application/json");
        out.body() = json_text(run_.frame(std::stoul(parameter(query, "number"))));
      } else if (path == "/state") {
        out.set(http::field::content_type, "application/json");
        out.body() = json_text(run_.state(parameter(query, "known")));
      } else {
        return;
      }
      out.result(http::status::ok);
    } catch (const std::exception& error) {
      out.set(http::field::content_type, "text/plain; charset=utf-8");
      out.body() = error.what();
    }
  }

  ServedRun run_;
  int port_;
  std::string token_;
};

/// One connection: reads a request, answers it, and again until either side closes. All connections share one thread:
/// the HDF5 library is for one.
class Connection : public std::enable_shared_from_this<Connection> {
 public:
  using Reply = std::function<Answer(const Request&)>;
  Connection(asio::ip::tcp::socket socket, Reply reply) : stream_(std::move(socket)), reply_(std::move(reply)) {}

  void read() {
    asked_ = {};
    stream_.expires_after(std::chrono::seconds(60));  // a browser keeps a connection for later
    http::async_read(stream_, buffer_, asked_,
                     [self = shared_from_this()](boost::system::error_code error, std::size_t) {
                       if (!error) self->write();
                     });
  }

 private:
  void write() {
    answer_ = reply_(asked_);
    stream_.expires_after(std::chrono::seconds(60));
    http::async_write(stream_, answer_, [self = shared_from_this()](boost::system::error_code error, std::size_t) {
      if (!error && self->answer_.keep_alive()) self->read();
    });
  }

  boost::beast::tcp_stream stream_;
  boost::beast::flat_buffer buffer_;
  Reply reply_;
  Request asked_;
  Answer answer_;
};

asio::ip::tcp::acceptor listening(asio::io_context& loop, int port) {
  try {
    return {loop, {asio::ip::address_v4::loopback(), static_cast<std::uint16_t>(port)}};
  } catch (const boost::system::system_error&) {
    throw std::invalid_argument(
        fmt::format("--port {}: cannot be listened on; leave --port out to take one that is free", port));
  }
}

class RunServer {
 public:
  explicit RunServer(const ServeRequest& request)
      : request_(request),
        acceptor_(listening(loop_, request.port)),
        timer_(loop_),
        pages_(request.run, acceptor_.local_endpoint().port()) {}

  void serve(const std::function<void(const std::string&)>& ready) {
    last_ = Clock::now();
    ready(pages_.address());
    accept();
    if (request_.idle > 0) stop_when_idle();
    loop_.run();
  }

 private:
  void accept() {
    acceptor_.async_accept([this](boost::system::error_code error, asio::ip::tcp::socket socket) {
      if (!error)
        std::make_shared<Connection>(std::move(socket), [this](const Request& asked) {
          Answer answer = pages_.answer(asked);
          if (pages_.known(asked)) last_ = Clock::now();  // reading takes time too
          return answer;
        })->read();
      accept();
    });
  }
  void stop_when_idle() {
    timer_.expires_after(std::chrono::milliseconds(200));
    timer_.async_wait([this](boost::system::error_code) {
      const double since = std::chrono::duration<double>(Clock::now() - last_).count();
      if (since >= request_.idle && !reported_progress(request_.run)) return loop_.stop();
      stop_when_idle();
    });
  }

  const ServeRequest& request_;
  asio::io_context loop_;
  asio::ip::tcp::acceptor acceptor_;
  asio::steady_timer timer_;
  RunPages pages_;
  Clock::time_point last_;
};

}  // namespace

void serve_run(const ServeRequest& request, const std::function<void(const std::string&)>& ready) {
  RunServer(request).serve(ready);
}

}  // namespace subsoil::sim
