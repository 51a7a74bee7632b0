#include "tools/lab/ct/snake.hpp"
#include "tools/mesh/fault.hpp"
#include <algorithm>
#include <itkGeodesicActiveContourLevelSetImageFilter.h>
#include <itkGradientMagnitudeRecursiveGaussianImageFilter.h>
#include <itkImage.h>
#include <itkSignedMaurerDistanceMapImageFilter.h>
#include <itkSmoothingRecursiveGaussianImageFilter.h>

namespace crn::ct
{

namespace
{

using Image = itk::Image<float, 3>;
using Mask = itk::Image<unsigned char, 3>;

// Makes an image with the size and spacing of the grid but without its position, because the filters need
// only the spacing.
template <class Type> typename Type::Pointer empty_image(const Volume &volume)
{
    const auto image = Type::New();
    typename Type::SizeType size;
    typename Type::SpacingType spacing;
    for (unsigned axis = 0; axis < 3; ++axis) {
        size[axis] = static_cast<itk::SizeValueType>(volume.size[axis]);
        spacing[axis] = volume.spacing_mm[static_cast<Eigen::Index>(axis)];
    }
    image->SetRegions(size);
    image->SetSpacing(spacing);
    image->Allocate();
    return image;
}

Image::Pointer image_of(const Volume &volume)
{
    const Image::Pointer image = empty_image<Image>(volume);
    std::copy(volume.hu.begin(), volume.hu.end(), image->GetBufferPointer());
    return image;
}

// Runs a filter of ITK and copies the resulting image onto the volume's grid.
template <class Filter> Volume run(const Volume &grid, const Filter &filter)
{
    try {
        filter->SetNumberOfWorkUnits(1);
        filter->Update();
    } catch (const itk::ExceptionObject &error) {
        throw Fault(grid.name + ": the segmentation failed: " + error.GetDescription());
    }
    Volume result = grid.like(0);
    std::copy_n(filter->GetOutput()->GetBufferPointer(), result.count(), result.hu.begin());
    return result;
}

} // namespace

Volume smoothed(const Volume &volume, double sigma_mm)
{
    const auto filter = itk::SmoothingRecursiveGaussianImageFilter<Image, Image>::New();
    filter->SetInput(image_of(volume));
    filter->SetSigma(sigma_mm);
    return run(volume, filter);
}

Volume gradient_magnitude(const Volume &volume, double sigma_mm)
{
    const auto filter = itk::GradientMagnitudeRecursiveGaussianImageFilter<Image, Image>::New();
    filter->SetInput(image_of(volume));
    filter->SetSigma(sigma_mm);
    return run(volume, filter);
}

Volume speed_of(const Volume &gradient, double edge_HU_per_mm, double width_HU_per_mm)
{
    Volume speed = gradient;
    for (float &value : speed.hu)
        value = static_cast<float>(
            1 / (1 + std::exp((static_cast<double>(value) - edge_HU_per_mm) / width_HU_per_mm)));
    return speed;
}

Volume signed_distance(const Volume &mask)
{
    const Mask::Pointer image = empty_image<Mask>(mask);
    std::transform(mask.hu.begin(), mask.hu.end(), image->GetBufferPointer(),
                   [](float value) { return static_cast<unsigned char>(value > 0); });
    const auto filter = itk::SignedMaurerDistanceMapImageFilter<Mask, Image>::New();
    filter->SetInput(image);
    filter->SquaredDistanceOff();
    filter->UseImageSpacingOn();
    filter->InsideIsPositiveOff();
    return run(mask, filter);
}

Volume evolve_snake(const Volume &level, const Volume &speed, const SnakeWeights &weights)
{
    const auto filter = itk::GeodesicActiveContourLevelSetImageFilter<Image, Image>::New();
    filter->SetInput(image_of(level));
    filter->SetFeatureImage(image_of(speed));
    filter->SetPropagationScaling(static_cast<float>(weights.propagation));
    filter->SetCurvatureScaling(static_cast<float>(weights.curvature));
    filter->SetAdvectionScaling(static_cast<float>(weights.advection));
    filter->SetMaximumRMSError(0.001);
    // With the usual, larger sigma, the low-speed regions on the two sides of a wall merge, and the snake
    // (active contour) stops on the wrong side of the wall.
    filter->SetDerivativeSigma(0.3);
    filter->SetNumberOfIterations(static_cast<unsigned>(weights.iterations));
    return run(level, filter);
}

} // namespace crn::ct
