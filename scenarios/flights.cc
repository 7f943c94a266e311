// SPDX-License-Identifier: Apache-2.0
#include "scenarios/flights.h"

#include "mission/mission_type.h"
#include "scenarios/attitude/attitude.h"
#include "scenarios/avoid/avoid.h"
#include "scenarios/follow/follow.h"
#include "scenarios/ground/ground_calibration.h"
#include "scenarios/ground/ground_flights.h"
#include "scenarios/gyro_failure/gyro_failure.h"
#include "scenarios/hand_held/hand_held.h"
#include "scenarios/hover/hover.h"
#include "scenarios/hover_direct/hover_direct.h"
#include "scenarios/landing/landing.h"
#include "scenarios/landing_deck/landing_deck.h"
#include "scenarios/panorama/panorama.h"
#include "scenarios/pose/pose.h"
#include "scenarios/servo/servo.h"
#include "scenarios/stabilise/stabilise.h"
#include "scenarios/survey/survey.h"

namespace kestrel::scenarios {

void AddFlights() {
  static const bool kAdded = [] {
    mission::AddMission<PoseFlight>();
    mission::AddMission<HoverFlight>();
    mission::AddMission<LandingFlight>();
    mission::AddMission<LandingDeckFlight>();
    mission::AddMission<AttitudeFlight>();
    mission::AddMission<GyroFailureFlight>();
    mission::AddMission<FollowFlight>();
    mission::AddMission<AvoidFlight>();
    mission::AddMission<HandHeldFlight>();
    mission::AddMission<StabiliseFlight>();
    mission::AddMission<SurveyFlight>();
    mission::AddMission<PanoramaFlight>();
    mission::AddMission<ServoFlight>();
    mission::AddMission<HoverDirectFlight>();
    mission::AddMission<HoverGroundFlight>();
    mission::AddMission<LandingGroundFlight>();
    mission::AddMission<LandingHybridFlight>();
    mission::AddMission<GroundCalibrationFlight>();
    return true;
  }();
  (void)kAdded;
}

}  // namespace kestrel::scenarios
