// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "base/yaml/fields.h"

namespace kestrel::vision {

// A camera model that is not Kestrel's own, as a value: any type with the members of one that is, of which
// Pinhole is the smallest (vision/camera/pinhole.h), and its Fields. Asked as they are, by camera_model.h.
class AddedModel {
 public:
  template <class Model>
  requires requires { Model::kName; }
  explicit AddedModel(Model model)
      : AddedModel(std::shared_ptr<const Any>(std::make_shared<Of<Model>>(std::move(model)))) {}

  const char* name() const { return is_->Name(); }
  std::optional<Eigen::Vector2d> Project(const Eigen::Vector3d& p_CQ,
                                         Eigen::Matrix<double, 2, 3>* d_point = nullptr,
                                         Eigen::Matrix2Xd* d_parameters = nullptr) const {
    return is_->Project(p_CQ, d_point, d_parameters);
  }
  std::optional<Eigen::Vector3d> Ray(const Eigen::Vector2d& uv,
                                     Eigen::Matrix<double, 3, 2>* d_pixel = nullptr) const {
    return is_->Ray(uv, d_pixel);
  }
  double MaxAngle() const { return is_->MaxAngle(); }
  std::vector<std::string> ParameterNames() const { return is_->ParameterNames(); }
  Eigen::VectorXd Parameters() const { return is_->Parameters(); }
  void SetParameters(const Eigen::VectorXd& all) { *this = AddedModel(is_->With(all)); }

  // Those of the model itself.
  int width_px = 0, height_px = 0;
  double cx = 0, cy = 0;

  friend void Fields(FieldVisitor& v, AddedModel& camera) { camera = AddedModel(camera.is_->Visited(v)); }

 private:
  struct Any {
    virtual ~Any() = default;
    virtual const char* Name() const = 0;
    virtual std::optional<Eigen::Vector2d> Project(const Eigen::Vector3d& p_CQ,
                                                   Eigen::Matrix<double, 2, 3>* d_point,
                                                   Eigen::Matrix2Xd* d_parameters) const = 0;
    virtual std::optional<Eigen::Vector3d> Ray(const Eigen::Vector2d& uv,
                                               Eigen::Matrix<double, 3, 2>* d_pixel) const = 0;
    virtual double MaxAngle() const = 0;
    virtual std::vector<std::string> ParameterNames() const = 0;
    virtual Eigen::VectorXd Parameters() const = 0;
    virtual std::shared_ptr<const Any> With(const Eigen::VectorXd& parameters) const = 0;
    virtual std::shared_ptr<const Any> Visited(FieldVisitor& v) const = 0;  // as it is then
    int width_px = 0, height_px = 0;
    double cx = 0, cy = 0;
  };

  template <class Model>
  struct Of final : Any {
    explicit Of(Model a_model) : model(std::move(a_model)) {
      width_px = model.width_px, height_px = model.height_px;
      cx = model.cx, cy = model.cy;
    }
    const char* Name() const override { return Model::kName; }
    std::optional<Eigen::Vector2d> Project(const Eigen::Vector3d& p_CQ, Eigen::Matrix<double, 2, 3>* d_point,
                                           Eigen::Matrix2Xd* d_parameters) const override {
      return model.Project(p_CQ, d_point, d_parameters);
    }
    std::optional<Eigen::Vector3d> Ray(const Eigen::Vector2d& uv,
                                       Eigen::Matrix<double, 3, 2>* d_pixel) const override {
      return model.Ray(uv, d_pixel);
    }
    double MaxAngle() const override { return model.MaxAngle(); }
    std::vector<std::string> ParameterNames() const override { return model.ParameterNames(); }
    Eigen::VectorXd Parameters() const override { return model.Parameters(); }
    std::shared_ptr<const Any> With(const Eigen::VectorXd& parameters) const override {
      Model changed = model;
      changed.SetParameters(parameters);
      return std::make_shared<Of>(std::move(changed));
    }
    std::shared_ptr<const Any> Visited(FieldVisitor& v) const override {
      Model visited = model;
      Fields(v, visited);
      return std::make_shared<Of>(std::move(visited));
    }
    Model model;
  };

  explicit AddedModel(std::shared_ptr<const Any> is)
      : width_px(is->width_px), height_px(is->height_px), cx(is->cx), cy(is->cy), is_(std::move(is)) {}

  std::shared_ptr<const Any> is_;
};

// Adds a model by its defaults, which a camera file then names in its key `model`. A program does so before it
// reads a camera; two of one name are refused by std::logic_error.
void AddCameraModel(AddedModel defaults);
template <class Model>
void AddCameraModel() {
  AddCameraModel(AddedModel(Model{}));
}

}  // namespace kestrel::vision
