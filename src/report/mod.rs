//! Tables, figures and the HTML report: pure functions of rows and images.
