#include "libsim/view/serve.hpp"

#include <fmt/format.h>
#include <httplib.h>

#include <atomic>
#include <chrono>
#include <mutex>
#include <random>
#include <stdexcept>
#include <thread>

#include "libsim/run/output_folder.hpp"
#include "libsim/view/page.hpp"
#include "libsim/view/view.hpp"

namespace subsoil::sim {
namespace {

using Clock = std::chrono::steady_clock;

std::string random_token() {
  std::random_device source;  // of the system, not seeded
  std::string out;
  for (int k = 0; k < 4; ++k) out += fmt::format("{:08x}", source());
  return out;
}

class RunServer {
 public:
  explicit RunServer(const ServeRequest& request) : request_(request), run_(request.run), token_(random_token()) {
    server_.set_default_headers({{"Cache-Control", "no-store"},
                                 {"Referrer-Policy", "no-referrer"},
                                 {"X-Content-Type-Options", "nosniff"},
                                 {"Content-Security-Policy",
                                  "default-src 'none'; script-src 'unsafe-inline'; style-src 'unsafe-inline'; "
                                  "img-src data: blob:; media-src blob:; connect-src 'self'"}});
    server_.set_pre_routing_handler([this](const httplib::Request& asked, httplib::Response& answer) {
      const std::string host = asked.get_header_value("Host");
      const bool ours = host == fmt::format("127.0.0.1:{}", port_) || host == fmt::format("localhost:{}", port_);
      const bool known = asked.path.starts_with("/" + token_ + "/");
      if (ours && known && asked.method == "GET") {
        touch();
        return httplib::Server::HandlerResponse::Unhandled;
      }
      answer.status = 404;
      return httplib::Server::HandlerResponse::Handled;
    });
    answer("/", "text/html; charset=utf-8", [this](const auto&) { return scene_page(run_.scene()); });
    answer("/frame", "application/json", [this](const httplib::Request& asked) {
      return json_text(run_.frame(std::stoul(asked.get_param_value("number"))));
    });
    answer("/state", "application/json",
           [this](const httplib::Request& asked) { return json_text(run_.state(asked.get_param_value("known"))); });
  }

  void serve(const std::function<void(const std::string&)>& ready) {
    port_ = request_.port;
    const bool bound =
        port_ > 0 ? server_.bind_to_port("127.0.0.1", port_) : (port_ = server_.bind_to_any_port("127.0.0.1")) > 0;
    if (!bound)
      throw std::invalid_argument(
          fmt::format("--port {}: cannot be listened on; leave --port out to take one that is free", request_.port));
    touch();
    ready(fmt::format("http://127.0.0.1:{}/{}/", port_.load(), token_));
    std::thread watch;
    if (request_.idle > 0) watch = std::thread([this] { stop_when_idle(); });
    server_.listen_after_bind();
    if (watch.joinable()) watch.join();
  }

 private:
  void touch() { last_ = Clock::now().time_since_epoch().count(); }
  template <class Text>
  void answer(const std::string& path, const char* type, Text text) {
    server_.Get("/" + token_ + path, [this, type, text](const httplib::Request& asked, httplib::Response& out) {
      const std::lock_guard lock(reading_);  // the HDF5 library is for one thread
      try {
        out.set_content(text(asked), type);
      } catch (const std::exception& error) {
        out.status = 404;
        out.set_content(error.what(), "text/plain; charset=utf-8");
      }
      touch();  // reading takes time too
    });
  }
  void stop_when_idle() {
    while (true) {
      std::this_thread::sleep_for(std::chrono::milliseconds(200));
      const auto since = Clock::now() - Clock::time_point(Clock::duration(last_.load()));
      if (std::chrono::duration<double>(since).count() < request_.idle) continue;
      const std::unique_lock lock(reading_, std::try_to_lock);
      if (lock && !reported_progress(request_.run)) return server_.stop();
    }
  }

  const ServeRequest& request_;
  ServedRun run_;
  std::string token_;
  httplib::Server server_;
  std::mutex reading_;
  std::atomic<int> port_{0};
  std::atomic<Clock::rep> last_{0};
};

}  // namespace

void serve_run(const ServeRequest& request, const std::function<void(const std::string&)>& ready) {
  RunServer(request).serve(ready);
}

}  // namespace subsoil::sim
