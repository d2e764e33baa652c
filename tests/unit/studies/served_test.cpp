#include <gtest/gtest.h>

#include <boost/asio/ip/tcp.hpp>
#include <boost/beast/core.hpp>
#include <boost/beast/http.hpp>
#include <future>
#include <nlohmann/json.hpp>
#include <thread>

#include "libsim/run/output_folder.hpp"
#include "libsim/view/serve.hpp"
#include "libsim/view/view.hpp"
#include "tests/tools/packed.hpp"
#include "tests/tools/program_runs.hpp"

/// A run's picture over HTTP: what is answered to whom, and that frames on demand are those of the whole page.
namespace subsoil::sim::served_test {
namespace {

using Json = nlohmann::ordered_json;

class Served : public ::testing::Test {
 protected:
  static void SetUpTestSuite() {
    directory = new test::RunDirectory;
    ASSERT_EQ(test::run_scenario(directory->scenario(test::small_pass), *directory / "run"), exit_ok);
  }
  static void TearDownTestSuite() { delete directory; }
  static std::filesystem::path run() { return *directory / "run"; }
  static const test::RunDirectory* directory;
};
const test::RunDirectory* Served::directory = nullptr;

/// A browser's part: one request by a connection of its own.
class Client {
 public:
  using Answer = boost::beast::http::response<boost::beast::http::string_body>;
  explicit Client(std::string host) : host_(std::move(host)) {}

  Answer ask(boost::beast::http::verb verb, const std::string& path, const std::string& host = {},
             const std::string& body = {}) const {
    namespace http = boost::beast::http;
    boost::asio::io_context loop;
    boost::beast::tcp_stream stream(loop);
    const std::size_t colon = host_.find(':');
    stream.connect({boost::asio::ip::make_address(host_.substr(0, colon)),
                    static_cast<std::uint16_t>(std::stoul(host_.substr(colon + 1)))});
    http::request<http::string_body> request(verb, path, 11);
    request.set(http::field::host, host.empty() ? host_ : host);
    request.body() = body;
    if (!body.empty()) request.prepare_payload();
    http::write(stream, request);
    boost::beast::flat_buffer buffer;
    http::response_parser<http::string_body> answer;
    answer.body_limit(std::uint64_t{1} << 30);
    http::read(stream, buffer, answer);
    return answer.release();
  }
  Answer get(const std::string& path) const { return ask(boost::beast::http::verb::get, path); }

 private:
  std::string host_;  // name:port
};

/// Coordinates of a packed frame in the box of its page, m.
std::vector<double> places(const Json& frame, const Json& low, const Json& high, std::vector<std::uint16_t>& last) {
  const std::vector<unsigned char> bytes = test::unpacked(frame["position"].get<std::string>());
  const std::size_t n = bytes.size() / 6;
  last.resize(3 * n);
  std::vector<double> out(3 * n);
  for (std::size_t k = 0; k < 3; ++k)
    for (std::size_t i = 0; i < n; ++i) {
      last[3 * i + k] =
          static_cast<std::uint16_t>(last[3 * i + k] + bytes[2 * k * n + i] + 256U * bytes[(2 * k + 1) * n + i]);
      const double from = low[k].get<double>(), until = high[k].get<double>();
      out[3 * i + k] = from + last[3 * i + k] / 65534.0 * (until - from);
    }
  return out;
}

TEST_F(Served, FramesOnDemandAreThoseOfTheWholePage) {
  ViewRequest request;
  request.run = run();
  const Json whole = view_scene(request)["spheres"];
  ServedRun served(run());
  const Json scene = served.scene();
  EXPECT_TRUE(scene["served"]);
  ASSERT_EQ(scene["spheres"]["frames"].size(), whole["frames"].size());
  EXPECT_FALSE(scene["spheres"]["frames"][0].contains("position"));
  std::vector<std::uint16_t> last;
  for (std::size_t f = 0; f < whole["frames"].size(); ++f) {
    const std::vector<double> all = places(whole["frames"][f], whole["low"], whole["high"], last);
    if (f % 3 != 1) continue;  // in any order and not all
    const Json frame = served.frame(f);
    std::vector<std::uint16_t> none;
    const std::vector<double> one = places(frame, frame["low"], frame["high"], none);
    ASSERT_EQ(one.size(), all.size());
    const double error = frame["error"].get<double>() + whole["error"].get<double>();
    for (std::size_t i = 0; i < one.size(); ++i) ASSERT_NEAR(one[i], all[i], error * 1.01) << f;
  }
  EXPECT_THROW(served.frame(whole["frames"].size()), std::out_of_range);
}

TEST_F(Served, TheStateIsSentOnceUntilTheFolderChanges) {
  ServedRun served(run());
  const Json first = served.state("");
  EXPECT_TRUE(first["progress"].is_null()) << "the run has ended";
  EXPECT_EQ(first["frames"].size(), test::frame_times(run()).size());
  EXPECT_FALSE(served.state(first["stamp"]).contains("motion"));
  std::filesystem::last_write_time(run() / "series.csv",
                                   std::filesystem::last_write_time(run() / "series.csv") + std::chrono::seconds(1));
  EXPECT_TRUE(served.state(first["stamp"]).contains("motion"));
}

TEST_F(Served, AnActiveRunReportsItsProgressAndAnEndedOneDoesNot) {
  const test::RunDirectory scratch;
  const std::filesystem::path other = scratch / "run";
  EXPECT_FALSE(reported_progress(other).has_value());
  {
    FolderLock lock(other);
    EXPECT_EQ(reported_progress(other), "");
    lock.report_progress(R"({"time": 1, "warnings": ["a", "b"]})");
    EXPECT_EQ(reported_progress(other), R"({"time": 1, "warnings": ["a", "b"]})");
    lock.report_progress("{}");
    EXPECT_EQ(reported_progress(other), "{}") << "nothing of the longer text is left";
  }
  EXPECT_FALSE(reported_progress(other).has_value());
}

TEST_F(Served, OnlyTheAddressWithItsTokenIsAnsweredAndOnlyGet) {
  ServeRequest request;
  request.run = run();
  request.idle = 1;
  std::promise<std::string> address;
  std::thread server([&] { serve_run(request, [&](const std::string& url) { address.set_value(url); }); });
  const std::string url = address.get_future().get();
  const std::size_t slash = url.find('/', 7);
  const std::string host = url.substr(7, slash - 7), path = url.substr(slash);
  EXPECT_EQ(host.substr(0, 10), "127.0.0.1:");
  EXPECT_EQ(path.size(), 34U) << "128 bits in hexadecimal between two slashes";
  using boost::beast::http::verb;
  const Client client(host);
  const auto status = [](const Client::Answer& answer) { return answer.result_int(); };
  EXPECT_EQ(status(client.get(path)), 200U);
  EXPECT_EQ(status(client.get("/")), 404U);
  EXPECT_EQ(status(client.get("/frame?number=0")), 404U);
  std::string guess = path;
  guess[5] = guess[5] == '0' ? '1' : '0';
  EXPECT_EQ(status(client.get(guess)), 404U);
  EXPECT_EQ(status(client.ask(verb::post, path)), 404U);
  EXPECT_EQ(status(client.ask(verb::delete_, path + "frame")), 404U);
  EXPECT_EQ(status(client.get(path + "frame?number=100000")), 404U);
  EXPECT_EQ(status(client.get(path + "frame?number=x")), 404U);
  EXPECT_EQ(status(client.get(path + "frame?n=0")), 404U);
  EXPECT_EQ(status(client.get(path + "../run.h5")), 404U);
  EXPECT_EQ(status(client.ask(verb::get, path, "evil.example")), 404U)
      << "a name that another site lets resolve to this machine";
  EXPECT_THROW(client.ask(verb::get, path, {}, "x"), boost::system::system_error) << "a request with a body";
  const Client::Answer frame = client.get(path + "frame?number=0");
  ASSERT_EQ(status(frame), 200U);
  EXPECT_TRUE(Json::parse(frame.body()).contains("position"));
  EXPECT_EQ(frame["Cache-Control"], "no-store");
  server.join();  // ends by itself after a second without a request
}

}  // namespace
}  // namespace subsoil::sim::served_test
