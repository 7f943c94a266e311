// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>
#include <memory>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

namespace kestrel {

// Chromium without a screen, driven by the WebDriver protocol through chromedriver, with a profile of its own
// that ends with it.
class Browser {
 public:
  // What is not installed of it; empty: nothing is missing.
  static std::string Missing();

  enum class WebGl { kNone, kSoftware };

  // folder: of its profile and its log. Throws std::runtime_error, here and later, with what the driver said.
  Browser(const std::filesystem::path& folder, WebGl webgl);
  ~Browser();

  void Open(const std::filesystem::path& page);  // as a file://
  void OpenUrl(const std::string& url);
  // The body of a function of JavaScript, and what it returns.
  nlohmann::json Run(const std::string& script);
  void Click(const std::string& css);  // as a mouse does, on what must be there and visible
  void Choose(const std::string& css, const std::string& option);
  void Type(const std::string& css, const std::string& text);
  // A click at a place of the window, in its pixels.
  void ClickAt(double x, double y);
  void PreferDark(bool dark);
  void Resize(int width, int height);
  void SavePicture(const std::filesystem::path& png);  // of what the window shows
  std::string Print();                                 // PDF

  // What the page wrote to the console as errors or warnings, and what it asked of any network, since the
  // last call.
  std::vector<std::string> Complaints();
  std::vector<std::string> Requests();

 private:
  struct Driver;
  std::unique_ptr<Driver> driver_;
};

}  // namespace kestrel
