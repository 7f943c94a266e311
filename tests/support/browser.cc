// SPDX-License-Identifier: Apache-2.0
#include "tests/support/browser.h"

#include <fmt/format.h>

#include <boost/asio/connect.hpp>
#include <boost/asio/ip/tcp.hpp>
#include <boost/beast/core.hpp>
#include <boost/beast/core/detail/base64.hpp>
#include <boost/beast/http.hpp>
#include <chrono>
#include <fstream>
#include <regex>
#include <stdexcept>
#include <thread>

#include "base/process/child_process.h"

namespace kestrel {
namespace {

namespace fs = std::filesystem;
namespace http = boost::beast::http;
using Json = nlohmann::json;
using boost::asio::ip::tcp;

constexpr const char* kChromium = "/usr/bin/chromium";
constexpr const char* kDriver = "/usr/bin/chromedriver";
constexpr const char* kElement = "element-6066-11e4-a52e-4f735466cecf";  // WebDriver's name of an element

std::string Decoded(const std::string& base64) {
  namespace coding = boost::beast::detail::base64;
  std::string bytes(coding::decoded_size(base64.size()), '\0');
  bytes.resize(coding::decode(bytes.data(), base64.data(), base64.size()).first);
  return bytes;
}

}  // namespace

std::string Browser::Missing() {
  for (const char* program : {kChromium, kDriver})
    if (!fs::exists(program)) return fmt::format("there is no {}", program);
  return "";
}

struct Browser::Driver {
  Driver(const fs::path& folder, WebGl webgl)
      : program({kDriver, "--port=0"}, {"HOME=" + folder.string()}, folder / "chromedriver.log") {
    const auto deadline = std::chrono::steady_clock::now() + std::chrono::seconds(60);
    const std::regex started(R"(started successfully on port (\d+))");
    for (std::smatch match; port.empty();) {
      const std::string said = program.Output();
      if (std::regex_search(said, match, started)) port = match[1];
      if (program.Ended() || std::chrono::steady_clock::now() > deadline)
        throw std::runtime_error("chromedriver does not start: " + said);
      if (port.empty()) std::this_thread::sleep_for(std::chrono::milliseconds(5));
    }
    Json options = {
        {"binary", kChromium},
        {"args",
         {"--headless", "--no-sandbox", "--disable-quic", "--no-first-run", "--disable-background-networking",
          "--disable-component-update", "--disable-sync", "--disable-dev-shm-usage", "--hide-scrollbars",
          "--force-color-profile=srgb", "--user-data-dir=" + (folder / "profile").string()}}};
    options["args"].push_back("--disable-gpu");
    options["args"].push_back(webgl == WebGl::kNone ? "--disable-3d-apis" : "--enable-unsafe-swiftshader");
    const Json wanted = {{"goog:chromeOptions", options},
                         {"goog:loggingPrefs", {{"browser", "ALL"}, {"performance", "ALL"}}}};
    session =
        "/session/" +
        Send("/session", {{"capabilities", {{"alwaysMatch", wanted}}}}).at("sessionId").get<std::string>();
  }
  ~Driver() {
    try {
      Call(http::verb::delete_, session, "");
    } catch (const std::exception&) {  // it ends with its program
    }
  }

  Json Call(http::verb verb, const std::string& target, const std::string& body) {
    boost::asio::io_context context;
    boost::beast::tcp_stream stream(context);
    stream.expires_after(std::chrono::seconds(120));
    stream.connect(
        tcp::endpoint(boost::asio::ip::address_v4::loopback(), static_cast<std::uint16_t>(std::stoi(port))));
    http::request<http::string_body> request(verb, target, 11, body);
    request.set(http::field::host, "127.0.0.1:" + port);
    request.set(http::field::content_type, "application/json");
    request.prepare_payload();
    http::write(stream, request);
    boost::beast::flat_buffer buffer;
    http::response_parser<http::string_body> response;
    response.body_limit(boost::none);
    http::read(stream, buffer, response);
    const Json answer = Json::parse(response.get().body());
    if (response.get().result() != http::status::ok)
      throw std::runtime_error(fmt::format("{}: {}", target, answer["value"]["message"].get<std::string>()));
    return answer.at("value");
  }
  Json Send(const std::string& target, const Json& body) {
    return Call(http::verb::post, target, body.dump());
  }
  Json Command(const std::string& target, const Json& body) { return Send(session + target, body); }
  Json DevTools(const char* command, const Json& parameters) {
    return Command("/goog/cdp/execute", {{"cmd", command}, {"params", parameters}});
  }
  std::string Element(const std::string& css) {
    return Command("/element", {{"using", "css selector"}, {"value", css}}).at(kElement);
  }
  Json Log(const char* type) { return Command("/se/log", {{"type", type}}); }

  ChildProcess program;
  std::string port, session;
};

Browser::Browser(const fs::path& folder, WebGl webgl) {
  fs::remove_all(folder);
  fs::create_directories(folder);
  driver_ = std::make_unique<Driver>(folder, webgl);
  driver_->Command("/url", {{"url", "about:blank"}});
  Complaints(), Requests();  // of the page that it begins with
}

Browser::~Browser() = default;

void Browser::Open(const fs::path& page) { OpenUrl("file://" + fs::absolute(page).string()); }

void Browser::OpenUrl(const std::string& url) { driver_->Command("/url", {{"url", url}}); }

Json Browser::Run(const std::string& script) {
  return driver_->Command("/execute/sync", {{"script", script}, {"args", Json::array()}});
}

void Browser::Click(const std::string& css) {
  const std::string element = driver_->Element(css);
  // What stays at the top of the window would cover what WebDriver itself scrolls to.
  driver_->Command("/execute/sync", {{"script", "arguments[0].scrollIntoView({block: 'center'})"},
                                     {"args", {{{kElement, element}}}}});
  driver_->Command("/element/" + element + "/click", Json::object());
}

void Browser::Choose(const std::string& css, const std::string& option) {
  Click(fmt::format("{} option[value='{}']", css, option));
}

void Browser::Type(const std::string& css, const std::string& text) {
  driver_->Command("/element/" + driver_->Element(css) + "/value", {{"text", text}});
}

void Browser::ClickAt(double x, double y) {
  const Json move = {{"type", "pointerMove"}, {"duration", 0}, {"x", std::lround(x)}, {"y", std::lround(y)}};
  const Json mouse = {
      {"type", "pointer"},
      {"id", "mouse"},
      {"actions", {move, {{"type", "pointerDown"}, {"button", 0}}, {{"type", "pointerUp"}, {"button", 0}}}}};
  driver_->Command("/actions", {{"actions", Json::array({mouse})}});
}

void Browser::PreferDark(bool dark) {
  const Json feature = {{"name", "prefers-color-scheme"}, {"value", dark ? "dark" : "light"}};
  driver_->DevTools("Emulation.setEmulatedMedia", {{"features", Json::array({feature})}});
}

void Browser::Resize(int width, int height) {
  driver_->DevTools(
      "Emulation.setDeviceMetricsOverride",
      {{"width", width}, {"height", height}, {"deviceScaleFactor", 1}, {"mobile", width < 500}});
}

void Browser::SavePicture(const fs::path& png) {
  const Json picture = driver_->DevTools("Page.captureScreenshot", {{"format", "png"}});
  std::ofstream(png, std::ios::binary) << Decoded(picture.at("data"));
}

std::string Browser::Print() {
  return Decoded(driver_->DevTools("Page.printToPDF", {{"printBackground", true}}).at("data"));
}

std::vector<std::string> Browser::Complaints() {
  std::vector<std::string> complaints;
  for (const Json& entry : driver_->Log("browser")) {
    const std::string message = entry.at("message");
    const bool driver =
        message.find("GL Driver Message") != std::string::npos;  // of its speed, not of the page
    if (entry.at("level") != "INFO" && entry.at("level") != "DEBUG" && !driver) complaints.push_back(message);
  }
  return complaints;
}

std::vector<std::string> Browser::Requests() {
  std::vector<std::string> urls;
  for (const Json& entry : driver_->Log("performance")) {
    const Json message = Json::parse(entry.at("message").get<std::string>()).at("message");
    if (message.at("method") == "Network.requestWillBeSent")
      urls.push_back(message["params"]["request"]["url"]);
  }
  return urls;
}

}  // namespace kestrel
